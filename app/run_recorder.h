// The recorder of a run on a robot: the recording that was asked for, and the black box, which is always on
// unless it is switched off.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "app/recording_preface.h"
#include "runtime/recorder.h"

namespace headway::app {

struct RunRecorderOptions {
  std::filesystem::path record;  ///< folder; empty: no recording
  std::string black_box;         ///< folder, or "off"; empty: as the robot file says, or the default
  bool on_demand = false;        ///< the page may begin and end recordings
};

/// Made ahead of the session, which must end before it. Ends the recording, and writes the black box where an
/// exception is on its way.
class RunRecorder {
 public:
  /// Throws InputError where it cannot write there.
  RunRecorder(const RunRecorderOptions& options, const Robot& robot, const LiveOptions& live,
              hal::Clock& clock);
  ~RunRecorder();
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  /// Null where nothing is wanted.
  runtime::Recorder* get() { return recorder_.get(); }
  void start() {
    if (recorder_) recorder_->start();
  }
  void fault(const std::string& what) {
    if (recorder_) recorder_->fault(what);
  }
  /// The session has ended: so does the recording.
  void stop() {
    if (recorder_) recorder_->stop();
  }
  /// Says each news once.
  void tell(const std::function<void(const std::string&)>& say);

 private:
  std::unique_ptr<runtime::Recorder> recorder_;
  int exceptions_;  ///< under way when it was made
};

}  // namespace headway::app
