#include "bench/runtime_live_bus.h"

#include <sched.h>

#include "hal/error.h"
#include "sim_hal/world_file.h"
#include "tests/heap_count.h"
#include "tests/source_dir/source_dir.h"

namespace headway::bench {

std::size_t Wire::receive(std::span<hal::CanFrame> into) noexcept {
  const std::uint64_t heap = heap_allocations();
  // The loop's thread looks first; at the end others lead the head's drives out.
  if (loop_ == std::thread::id()) {
    loop_ = std::this_thread::get_id();
    heap_first_ = heap;
    first_look_ = hal::MonotonicClock().now();
  }
  if (loop_ == std::this_thread::get_id()) heap_last_ = heap;
  std::size_t count = 0;
  while (count < into.size() && to_loop_.pop(into[count])) ++count;
  return count;
}

void Wire::exchange_with(hal::CanBus& robot) {
  hal::CanFrame frame;
  while (to_robot_.pop(frame)) robot.send(frame);
  while (robot.receive({&frame, 1}) > 0) to_loop_.push(frame);
}

namespace {

sim::World laboratory() { return sim::read_world(source_dir() / "config/worlds/lab.yaml"); }

/// The calling thread, where there is another processor.
void keep_off(int processor) {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (::sched_getaffinity(0, sizeof set, &set) != 0 || CPU_COUNT(&set) < 2) return;
  CPU_CLR(static_cast<unsigned>(processor), &set);
  ::sched_setaffinity(0, sizeof set, &set);
}

app::Robot with(app::Robot robot, const runtime::RealTime& real_time) {
  robot.loops.real_time = real_time;
  robot.mapper.voxels.resolution = 0.05;
  return robot;
}

}  // namespace

LiveBus::LiveBus(const app::Robot& robot, const runtime::RealTime& real_time)
    : node_(robot, laboratory(), {}, false, clock_.now()),
      session_(std::make_unique<app::LiveSession>(
          with(robot, real_time), app::LiveOptions{.start = laboratory().start, .floor = {8, 8}, .goal = {}},
          wire_, eyes_, clock_)) {
  session_->start();
  nodes_ = std::thread([this, processor = real_time.bus_processor] { move_robot(processor); });
}

LiveBus::~LiveBus() {
  session_->stop();
  over_ = true;
  nodes_.join();
}

void LiveBus::move_robot(std::optional<int> bus_processor) {
  if (bus_processor) keep_off(*bus_processor);
  const Duration period = sim::SimRobot::kPeriod;
  while (wire_.first_look() == Time{} && !over_) clock_.sleep_until(clock_.now() + period);
  for (Time next = wire_.first_look() + period / 2; !over_; next += period) {
    clock_.sleep_until(next);
    wire_.exchange_with(node_.bus());
    node_.catch_up(clock_.now());
    wire_.exchange_with(node_.bus());
  }
}

LiveBus::Result LiveBus::stop() {
  const bool stands = session_->stop();
  app::LiveStatus status;
  session_->look(status);
  if (!stands || status.head != hal::HeadHealth::kReady)
    throw Error("the simulated robot was not there to the end: nothing was measured");
  return {session_->loops().figures(), wire_.heap_calls()};
}

}  // namespace headway::bench
