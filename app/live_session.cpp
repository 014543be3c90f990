#include "app/live_session.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/loop_configs.h"
#include "app/loop_setup.h"
#include "hal/error.h"
#include "hal/on_floor.h"

namespace headway::app {

namespace {

void check(const LiveOptions& options) {
  if (!options.goal) return;
  const Eigen::Vector2d off = (options.goal->position - options.start.position()).cwiseAbs();
  if (off.x() < options.floor.x() / 2 && off.y() < options.floor.y() / 2) return;
  throw InputError(fmt::format(
      "--goal: ({:.2f}, {:.2f}) lies outside the floor in use, expected within {:.1f} x {:.1f} m "
      "around the start; --floor makes it larger",
      options.goal->position.x(), options.goal->position.y(), options.floor.x(), options.floor.y()));
}

}  // namespace

std::optional<Pose2> hear_where_it_stands(hal::CanBus& bus, hal::Clock& clock, Duration longest) {
  drivers::CanWalker walker(bus);
  std::array<hal::CanFrame, 32> frames;
  for (const Time end = clock.now() + longest; clock.now() < end;
       clock.sleep_until(clock.now() + seconds(0.005))) {
    while (const std::size_t count = bus.receive(frames))
      for (const hal::CanFrame& frame : std::span(frames).first(count)) walker.receive(frame);
    if (walker.chest().stamp != Time{}) return on_floor(walker.chest().odom_from_chest);
  }
  return std::nullopt;
}

const char* text_of(hal::HeadHealth health) {
  switch (health) {
    case hal::HeadHealth::kStarting:
      return "starting";
    case hal::HeadHealth::kReady:
      return "ready";
    case hal::HeadHealth::kDegraded:
      return "degraded: its position stays away";
    case hal::HeadHealth::kNotHomed:
      return "not homed: a drive does not know where its joint is";
    case hal::HeadHealth::kFault:
      return "at fault";
  }
  return "?";
}

const char* text_of(hal::WalkerHealth health) {
  switch (health) {
    case hal::WalkerHealth::kStarting:
      return "not heard yet";
    case hal::WalkerHealth::kReady:
      return "ready";
    case hal::WalkerHealth::kNoChest:
      return "without chest pose";
    case hal::WalkerHealth::kLost:
      return "lost";
  }
  return "?";
}

LiveSession::LiveSession(const Robot& robot, const LiveOptions& options, hal::CanBus& bus,
                         runtime::Eyes& eyes, hal::Clock& clock)
    : robot_(with(loop_setup(robot, options), robot)),
      taps_(options.recorder),
      bus_(taps_.bus(bus, clock)),
      head_(bus_, head_config(robot_)),
      walker_(bus_),
      links_(std::make_unique<runtime::Links>()),
      mapper_(robot_.mapper, options.start),
      mission_(robot_.mission, mapper_.floor().grid),
      bus_loop_(bus_config(robot_, options.start), bus_, head_, walker_, *links_),
      frames_(frame_config(robot_, options.frame_rate), eyes, mapper_, mission_, *links_,
              taps_.stopwatch(clock)),
      loops_({}, clock, bus_loop_, frames_, *links_) {
  check(options);
  loops_.on_update([this] { report(); });
  frames_.observe([this](const runtime::FrameSnapshot& snapshot) { taps_.see(snapshot); });
  taps_.watch(bus_loop_, frames_);
  if (!options.goal) return;
  taps_.set(*options.goal, clock.now());
  mission_.set_goal(*options.goal);
}

/// In the frame loop's thread.
void LiveSession::report() {
  const runtime::BusReport& bus = links_->report.value();
  LiveStatus status;
  status.stamp = bus.stamp;
  status.state = mission_.state();
  const std::string& reason = mission_.reason();
  std::copy_n(reason.begin(), std::min(reason.size(), status.reason.size() - 1), status.reason.begin());
  status.base = frames_.localisation().steady() * bus.committed.stance.base();
  status.head = bus.head.health;
  status.walker = bus.walker;
  status_.publish(status);
}

bool LiveSession::look(LiveStatus& into) {
  if (!status_.update()) return false;
  into = status_.value();
  return true;
}

}  // namespace headway::app
