#include "app/live_session.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "app/leave_head.h"
#include "app/loop_configs.h"
#include "app/loop_setup.h"
#include "hal/error.h"
#include "hal/on_floor.h"

namespace headway::app {

namespace {

void check(const nav::Goal& goal, const LiveOptions& options) {
  const Eigen::Vector2d off = (goal.position - options.start.position()).cwiseAbs();
  if (off.x() < options.floor.x() / 2 && off.y() < options.floor.y() / 2) return;
  throw InputError(
      fmt::format("goal: ({:.2f}, {:.2f}) in the map lies outside the floor in use, expected within {:.1f} x "
                  "{:.1f} m around "
                  "({:.2f}, {:.2f}), where the robot was set up; 'headway run --floor' makes it larger",
                  goal.position.x(), goal.position.y(), options.floor.x(), options.floor.y(), options.start.x,
                  options.start.y));
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
      options_(options),
      clock_(clock),
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
      loops_(robot_.loops, clock, bus_loop_, frames_, *links_) {
  loops_.on_update([this] { report(); });
  frames_.observe([this](const runtime::FrameSnapshot& snapshot) { taps_.see(snapshot); });
  taps_.watch(bus_loop_, frames_);
  if (!options.goal) return;
  check(*options.goal, options);
  taps_.set(*options.goal, clock.now());
  mission_.set_goal(*options.goal);
}

void LiveSession::go(const nav::Goal& goal) {
  check(goal, options_);
  const runtime::SafetyReport& now = safety();
  if (now.state == runtime::SafetyState::kFault)
    throw InputError("the control computer reports a fault; look at it, then 'headway reset'");
  for (std::size_t i = 0; i < runtime::kSources; ++i)
    if (now.sources[i].level == runtime::SourceLevel::kLost)
      throw InputError(fmt::format("{} lost; nothing is walked until it is back",
                                   name(static_cast<runtime::SafetySource>(i))));
  if (!links_->goals.push({goal, now.stops}))
    throw Error("the frame loop takes no goals; does it hang? See 'headway status'");
}

void LiveSession::stay() {
  ++word_.stops;
  links_->operator_word.publish(word_);
}

void LiveSession::reset() {
  ++word_.resets;
  links_->operator_word.publish(word_);
}

const runtime::SafetyReport& LiveSession::safety() const {
  links_->safety_now.update();
  return links_->safety_now.value();
}

bool LiveSession::stop() noexcept {
  const bool rests = loops_.stop();
  const bool bus_hangs = std::string_view(loops_.left_hanging()) == "bus";  // and may yet use the head
  if (!bus_hangs && !head_.has_left()) leave_head(head_, bus_, clock_);
  return rests;
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
  status.level = frames_.level();
  status.at_rest = bus.committed.at_rest;
  status.goal = mission_.goal();
  status.short_of_goal = mission_.short_of_goal();
  status.frames = frames_.counters();
  status.mission = mission_.counters();
  status.times = frames_.times();
  status_.publish(status);
}

bool LiveSession::look(LiveStatus& into) {
  if (!status_.update()) return false;
  into = status_.value();
  return true;
}

}  // namespace headway::app
