// The frame loop's work done again from a recording, by all that the recording was made with.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/live_status.h"
#include "app/recording_preface.h"
#include "runtime/eyes.h"
#include "runtime/replay.h"

namespace headway::app {

class ReplaySession {
 public:
  /// `first`: the first file of a recording. Throws as recorded_setup.
  explicit ReplaySession(recording::McapReader& first);

  /// Goes through one file; the parts of a recording in their order. Throws InputError for a file without
  /// messages, or with such that are none.
  void run(recording::McapReader& part);
  /// Called ahead of each work, with the time at which it was done; what it throws ends the run.
  void before_each_work(std::function<void(Time)> what) { before_ = std::move(what); }
  void observe(runtime::FrameObserver observer) { replay_->observe(std::move(observer)); }
  LiveStatus status() const { return live_status(frames_, mission_, links_->report.value()); }

  const runtime::ReplayResult& result() const { return replay_->result(); }
  const runtime::Mapper& mapper() const { return mapper_; }
  const runtime::FrameLoop& frame_loop() const { return frames_; }
  const LoopSetup& setup() const { return setup_.setup; }
  const Robot& robot() const { return setup_.robot; }

 private:
  runtime::Eyes& make_eyes();

  RecordedSetup setup_;
  runtime::OfferedStereoCamera stereo_;
  runtime::OfferedDepthCamera depth_;
  runtime::RecordedStopwatch stopwatch_;
  std::unique_ptr<runtime::Eyes> eyes_;
  std::unique_ptr<runtime::Links> links_;
  runtime::Mapper mapper_;
  runtime::Mission mission_;
  runtime::FrameLoop frames_;
  std::unique_ptr<runtime::Replay> replay_;
  std::function<void(Time)> before_;
};

/// The same recording's parts in their order: FILE_00.mcap, FILE_01.mcap, ... for the first of them; else the
/// file alone.
std::vector<std::filesystem::path> parts_of(const std::filesystem::path& file);

}  // namespace headway::app
