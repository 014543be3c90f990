// What the frame loop's work rests upon besides the robot file: what a command's options have made of it. A
// recording keeps it, so that a replay begins with the same.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "app/live_session.h"
#include "app/report.h"
#include "app/robot_file.h"
#include "app/sim_session.h"

namespace headway::app {

struct LoopSetup {
  bool range_mode = false;  ///< eyes that measure depth, as the simulator's range mode has them
  Pose2 start;              ///< of the robot in its odometry frame
  Eigen::Vector3d lowest{0, 0, 0}, highest{0, 0, 0};  ///< corners of what is mapped [m]
  double frame_rate = 15;                             ///< of the cameras [Hz]
  std::string execution = "steps", matcher = "census";
  double step_over = 0;  ///< [m]
  bool replan = true, localise = true;
  std::uint64_t seed = 0;  ///< of the simulated cameras
};

LoopSetup loop_setup(const Robot& robot, const sim::World& world, const SimOptions& options);
LoopSetup loop_setup(const Robot& robot, const LiveOptions& options);

/// The robot as the loops are to know it. Throws InputError for a map that cannot be.
Robot with(const LoopSetup& setup, Robot robot);

Json to_json(const LoopSetup& setup);
/// Throws InputError where something is missing or is no such value.
LoopSetup loop_setup_from(const std::string& json);

}  // namespace headway::app
