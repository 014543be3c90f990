// The simulated robot at the other end of real wires: it moves with a clock, not with the program that guides
// it.
#pragma once

#include <memory>

#include "app/robot_file.h"
#include "app/simulated_robot.h"
#include "sim_hal/robot.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_camera.h"
#include "sim_hal/sim_depth_camera.h"
#include "sim_hal/world.h"

namespace headway::app {

class NodeSession {
 public:
  /// Switched on at `begin`. `range_mode`: one camera that measures depth in place of two. Throws InputError
  /// as simulated_pair does.
  NodeSession(const Robot& robot, const sim::World& world, const SimulatedRobotOptions& options,
              bool range_mode, Time begin);

  /// Moves world and robot on to `now`, in the simulator's periods.
  void catch_up(Time now);

  /// The vision computer's place on the robot's bus.
  hal::CanBus& bus() { return body_.bus(); }
  hal::StereoCamera* pair() { return pair_.get(); }   ///< null in range mode
  hal::DepthCamera* depth() { return depth_.get(); }  ///< null without
  /// What sees with that depth camera.
  const runtime::DepthEyes::Config& depth_eyes() const { return depth_eyes_; }

  // Truth.
  const sim::SimRobot& body() const { return body_; }

 private:
  void make_cameras(const Robot& robot, std::uint64_t seed, bool range_mode);

  hal::ManualClock clock_;  ///< the simulator's
  sim::Scene scene_;
  sim::SimRobot body_;
  std::unique_ptr<sim::SimStereoCamera> pair_;
  std::unique_ptr<sim::SimDepthCamera> depth_;
  runtime::DepthEyes::Config depth_eyes_;
};

}  // namespace headway::app
