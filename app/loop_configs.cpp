#include "app/loop_configs.h"

namespace headway::app {

runtime::BusLoopConfig bus_config(const Robot& robot, const Pose2& start) {
  runtime::BusLoopConfig config;
  config.stance = hal::Stance::parallel(start, robot.mission.gait.feet_apart);
  config.steps = robot.steps;
  return config;
}

runtime::FrameLoopConfig frame_config(const Robot& robot, double frame_rate) {
  runtime::FrameLoopConfig config;
  config.levelling = robot.levelling;
  config.localisation = robot.localisation;
  config.neck = robot.mission.neck;
  config.camera_time_offset = robot.camera_time_offset;
  config.budget.period = seconds(1 / frame_rate);
  return config;
}

drivers::HeadConfig head_config(const Robot& robot) {
  drivers::HeadConfig config;
  config.limits = robot.mission.head;
  config.set_points = robot.hardware.set_points;
  config.homing = robot.hardware.homing;
  return config;
}

}  // namespace headway::app
