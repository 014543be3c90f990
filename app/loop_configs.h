// What the loops and drivers must know of a robot, in simulation and on its vision computer alike.
#pragma once

#include "app/robot_file.h"
#include "drivers/cia402_head.h"
#include "runtime/bus_loop.h"
#include "runtime/frame_loop.h"

namespace headway::app {

/// `start`: where the robot stands, midway between its feet, in the odometry frame.
runtime::BusLoopConfig bus_config(const Robot& robot, const Pose2& start);

/// `frame_rate` of the cameras [Hz].
runtime::FrameLoopConfig frame_config(const Robot& robot, double frame_rate);

drivers::HeadConfig head_config(const Robot& robot);

}  // namespace headway::app
