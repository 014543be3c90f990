// The simulated robot in a small empty room, moving by the clock of the program that leads it on its threads.
#pragma once

#include <atomic>
#include <span>
#include <thread>

#include "app/node_session.h"
#include "app/sim_session.h"
#include "hal/error.h"
#include "tests/source_dir/source_dir.h"

namespace headway::app {

/// On a machine that others share, a clock four times faster than real may miss any number of cycles.
inline Robot hrp2() {
  Robot robot = read_robot(source_dir() / "config/hrp2/robot.yaml");
  robot.loops.missed.most_missed = runtime::Cycle::kMostRemembered;
  return robot;
}

inline sim::World empty_room() {
  sim::World world;
  world.name = "empty room";
  world.floor = {{0.5, 0}, {5, 4}};
  sim::add_room(world, {0.5, 0}, {5, 4}, 2.2, 0);
  world.start = {-0.8, 0, 0};
  return world;
}

/// The robot behind its bus: it moves whenever the bus is looked at, by the bus loop's thread.
class RobotOnBus final : public hal::CanBus {
 public:
  RobotOnBus(NodeSession& node, const hal::Clock& clock) : node_(node), clock_(clock) {}

  bool send(const hal::CanFrame& frame) noexcept override { return node_.bus().send(frame); }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override {
    node_.catch_up(clock_.now());
    hal::DepthFrame frame;
    if (!blind && node_.depth()->take_newest(frame)) pictures.publish(frame);
    return node_.bus().receive(into);
  }
  hal::CanBusState state() const noexcept override { return node_.bus().state(); }

  std::atomic<bool> blind{false};
  hal::NewestSlot<hal::DepthFrame> pictures;

 private:
  NodeSession& node_;
  const hal::Clock& clock_;
};

/// Its pictures, on the frame loop's thread.
class Pictures final : public hal::DepthCamera {
 public:
  explicit Pictures(RobotOnBus& wires) : wires_(wires) {}
  bool take_newest(hal::DepthFrame& into) override {
    if (explode) throw Error("the cameras have melted");
    for (; hang; std::this_thread::yield()) hung = true;
    if (!wires_.pictures.update()) return false;
    into = wires_.pictures.value();
    return true;
  }
  std::atomic<bool> explode{false}, hang{false}, hung{false};

 private:
  RobotOnBus& wires_;
};

}  // namespace headway::app
