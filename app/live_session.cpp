#include "app/live_session.h"

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
      line_(*links_),
      mapper_(robot_.mapper, options.start),
      mission_(robot_.mission, mapper_.floor().grid),
      bus_loop_(bus_config(robot_, options.start), bus_, head_, walker_, *links_),
      frames_(frame_config(robot_, options.frame_rate), eyes, mapper_, mission_, *links_,
              taps_.stopwatch(clock)),
      loops_(robot_.loops, clock, bus_loop_, frames_, *links_) {
  loops_.on_update([this] { report(); });
  frames_.observe([this](const runtime::FrameSnapshot& snapshot) {
    taps_.see(snapshot);
    if (observer_) observer_(snapshot);
  });
  taps_.watch(bus_loop_, frames_);
  if (!options.goal) return;
  check(*options.goal, options);
  taps_.set(*options.goal, clock.now());
  mission_.set_goal(*options.goal);
}

void LiveSession::go(const nav::Goal& goal) {
  check(goal, options_);
  line_.go(goal);
}

bool LiveSession::stop() noexcept {
  const bool rests = loops_.stop();
  const bool bus_hangs = std::string_view(loops_.left_hanging()) == "bus";  // and may yet use the head
  if (!bus_hangs && !head_.has_left()) leave_head(head_, bus_, clock_);
  return rests;
}

/// In the frame loop's thread.
void LiveSession::report() { status_.publish(live_status(frames_, mission_, links_->report.value())); }

bool LiveSession::look(LiveStatus& into) {
  if (!status_.update()) return false;
  into = status_.value();
  return true;
}

}  // namespace headway::app
