#include "app/run_recorder.h"

#include <algorithm>
#include <exception>

#include "app/recording_folder.h"
#include "app/state_folder.h"

namespace headway::app {

namespace {

runtime::RecorderConfig config_for(const RunRecorderOptions& options, const Robot& robot) {
  runtime::RecorderConfig config;
  config.picture_bytes = static_cast<std::size_t>(std::max(robot.rig.left.width, 0)) *
                         static_cast<std::size_t>(std::max(robot.rig.left.height, 0));
  if (!options.record.empty() || options.on_demand) {
    config.files.emplace().folder = recording_folder(options.record);
    config.files->rotate = robot.recording.file_bytes;
    config.record_at_once = !options.record.empty();
  }
  const std::string box = options.black_box.empty() ? robot.recording.black_box : options.black_box;
  if (box == "off") return config;
  config.black_box.emplace().folder = box.empty() ? state_folder() / "black_box" : std::filesystem::path(box);
  config.black_box->picture_bytes = robot.recording.black_box_bytes / 4 * 3;
  config.black_box->bytes = robot.recording.black_box_bytes - config.black_box->picture_bytes;
  return config;
}

}  // namespace

RunRecorder::RunRecorder(const RunRecorderOptions& options, const Robot& robot, const LiveOptions& live,
                         hal::Clock& clock)
    : exceptions_(std::uncaught_exceptions()) {
  const runtime::RecorderConfig config = config_for(options, robot);
  if (!config.files && !config.black_box) return;
  recorder_ = std::make_unique<runtime::Recorder>(
      config, recording_preface(robot, loop_setup(robot, live), "run"), clock, clock.now());
}

RunRecorder::~RunRecorder() {
  if (!recorder_) return;
  if (std::uncaught_exceptions() > exceptions_) recorder_->fault("the program ended by an exception");
  recorder_->stop();
}

void RunRecorder::tell(const std::function<void(const std::string&)>& say) {
  std::string text;
  while (recorder_ && recorder_->news(text)) say(text);
}

}  // namespace headway::app
