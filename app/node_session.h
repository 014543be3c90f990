// The simulated robot at the other end of real wires: it moves with a clock, not with the program that guides
// it.
#pragma once

#include <functional>
#include <memory>

#include "app/robot_file.h"
#include "app/simulated_robot.h"
#include "sim_hal/robot.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_depth_camera.h"
#include "sim_hal/world.h"

namespace headway::app {

class NodeSession {
 public:
  /// Mid-exposure of both cameras, the true pose of the left one (optical frame), and the world at that
  /// moment.
  using Exposed = std::function<void(Time, const Eigen::Isometry3d& map_from_left, const sim::WorldState&)>;

  /// Switched on at `begin`. `range_mode`: with one camera that measures depth.
  NodeSession(const Robot& robot, const sim::World& world, const SimulatedRobotOptions& options,
              bool range_mode, Time begin);

  /// Whom to tell of exposures, within catch_up().
  void on_exposure(Exposed exposed) { exposed_ = std::move(exposed); }

  /// Moves world and robot on to `now`, in the simulator's periods.
  void catch_up(Time now);

  /// The vision computer's place on the robot's bus.
  hal::CanBus& bus() { return body_.bus(); }
  hal::DepthCamera* depth() { return depth_.get(); }  ///< null but in range mode
  /// What sees with that depth camera.
  const runtime::DepthEyes::Config& depth_eyes() const { return depth_eyes_; }

  // Truth.
  const sim::SimRobot& body() const { return body_; }

 private:
  void make_depth_camera(const Robot& robot, std::uint64_t seed);

  hal::ManualClock clock_;  ///< the simulator's
  sim::Scene scene_;
  sim::SimRobot body_;
  Exposed exposed_;
  std::unique_ptr<sim::SimDepthCamera> depth_;
  runtime::DepthEyes::Config depth_eyes_;
};

}  // namespace headway::app
