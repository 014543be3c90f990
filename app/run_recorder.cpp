#include "app/run_recorder.h"

#include <algorithm>
#include <cstdlib>
#include <exception>

namespace headway::app {

namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

runtime::RecorderConfig config_for(const RunRecorderOptions& options, const Robot& robot) {
  runtime::RecorderConfig config;
  config.picture_bytes = static_cast<std::size_t>(std::max(robot.rig.left.width, 0)) *
                         static_cast<std::size_t>(std::max(robot.rig.left.height, 0));
  if (!options.record.empty()) {
    config.files.emplace().folder = options.record;
    config.files->rotate = robot.recording.file_bytes;
  }
  const std::string box = options.black_box.empty() ? robot.recording.black_box : options.black_box;
  if (box == "off") return config;
  config.black_box.emplace().folder = box.empty() ? default_black_box_folder() : std::filesystem::path(box);
  config.black_box->picture_bytes = robot.recording.black_box_bytes / 4 * 3;
  config.black_box->bytes = robot.recording.black_box_bytes - config.black_box->picture_bytes;
  return config;
}

}  // namespace

std::filesystem::path default_black_box_folder() {
  namespace fs = std::filesystem;
  // systemd separates several by colons; ours has one.
  if (const std::string state = variable("STATE_DIRECTORY"); !state.empty())
    return fs::path(state.substr(0, state.find(':'))) / "black_box";
  if (const std::string state = variable("XDG_STATE_HOME"); !state.empty())
    return fs::path(state) / "headway/black_box";
  if (const std::string home = variable("HOME"); !home.empty())
    return fs::path(home) / ".local/state/headway/black_box";
  return fs::temp_directory_path() / "headway/black_box";
}

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
