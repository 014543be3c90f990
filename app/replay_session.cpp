#include "app/replay_session.h"

#include <map>
#include <system_error>

#include <fmt/format.h>

#include "app/loop_configs.h"
#include "app/simulated_robot.h"
#include "hal/error.h"
#include "vision/rectify.h"

namespace headway::app {

ReplaySession::ReplaySession(recording::McapReader& first)
    : setup_(recorded_setup(first)),
      links_(std::make_unique<runtime::Links>()),
      mapper_(setup_.robot.mapper, setup_.setup.start),
      mission_(setup_.robot.mission, mapper_.floor().grid),
      frames_(frame_config(setup_.robot, setup_.setup.frame_rate), make_eyes(), mapper_, mission_, *links_,
              stopwatch_) {
  if (setup_.known) frames_.restore(*setup_.known);
  const bool range = setup_.setup.range_mode;
  replay_ = std::make_unique<runtime::Replay>(runtime::Replay::Parts{
      frames_, mission_, *links_, stopwatch_, range ? nullptr : &stereo_, range ? &depth_ : nullptr});
}

runtime::Eyes& ReplaySession::make_eyes() {
  const Robot& robot = setup_.robot;
  if (setup_.setup.range_mode) {
    const vision::Rectifier rectifier(robot.rig);
    const auto model = simulated_depth(robot, rectifier.rig(), setup_.setup.seed);
    eyes_ = std::make_unique<runtime::DepthEyes>(
        depth_, depth_eyes(model, rectifier.rectified_from_left().inverse()));
  } else {
    eyes_ = std::make_unique<runtime::StereoEyes>(stereo_, robot.rig, robot.vision);
  }
  return *eyes_;
}

void ReplaySession::run(recording::McapReader& part) {
  std::map<std::uint16_t, runtime::Topic> topics;
  std::set<std::uint16_t> channels;
  using runtime::Topic;
  for (const Topic topic : {Topic::kWork, Topic::kGoal, Topic::kLeft, Topic::kRight, Topic::kDepth}) {
    const auto channel = part.channel(runtime::kind(topic).name);
    if (!channel) continue;
    topics[*channel] = topic;
    channels.insert(*channel);
  }
  if (channels.empty()) throw InputError(part.name() + ": holds none of the topics that a replay needs");
  try {
    part.for_each(channels, [&](const recording::McapMessage& message) {
      if (before_ && topics.at(message.channel) == Topic::kWork) before_(message.log_time);
      replay_->take({topics.at(message.channel), message.sequence, message.log_time, message.bytes});
    });
  } catch (const recording::CdrError& fault) {
    throw InputError(fmt::format("{}: a message {}, expected one of 'headway run' or 'headway sim'",
                                 part.name(), fault.what()));
  }
}

std::vector<std::filesystem::path> parts_of(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> parts{file};
  const std::string stem = file.stem().string();
  std::error_code ignored;
  if (!stem.ends_with("_00")) return parts;
  for (int i = 1;; ++i) {
    const auto next = file.parent_path() / fmt::format("{}_{:02}{}", stem.substr(0, stem.size() - 3), i,
                                                       file.extension().string());
    if (!std::filesystem::exists(next, ignored)) return parts;
    parts.push_back(next);
  }
}

}  // namespace headway::app
