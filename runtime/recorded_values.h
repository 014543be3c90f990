// Between what the loops exchange and what a recording holds of it. Both ways nothing is lost: a replay gets
// the very numbers.
#pragma once

#include "hal/pose_history.h"
#include "nav/floor_map.h"
#include "nav/planner.h"
#include "runtime/links.h"
#include "runtime/recorded_messages.h"
#include "runtime/recording/ros_messages.h"

namespace headway::runtime {

recorded::BusReport to_recorded(const BusReport& report, bool with_steps = true);
BusReport from_recorded(const recorded::BusReport& report);
recorded::MotionOrder to_recorded(const MotionOrder& order);
recorded::Step to_recorded(const StepRecord& step);
recorded::ChestSample to_recorded(const hal::ChestSample& sample);
hal::ChestSample from_recorded(const recorded::ChestSample& sample);
recorded::HeadSample to_recorded(const HeadSample& sample);
HeadSample from_recorded(const recorded::HeadSample& sample);
recorded::GoalOrder to_recorded(const GoalOrder& order);
GoalOrder from_recorded(const recorded::GoalOrder& order);
recorded::LookOrder to_recorded(const LookOrder& order);
LookOrder from_recorded(const recorded::LookOrder& order);
recorded::Goal to_recorded(const nav::Goal& goal);
nav::Goal from_recorded(const recorded::Goal& goal);

/// CRC-32 of the cells.
std::uint32_t sum_of(const nav::FloorMap& floor);

// For viewers:
recording::ros::Transform transform(const Eigen::Isometry3d& pose);
recording::ros::PoseStamped pose_stamped(const Pose2& pose, Time stamp, const char* frame);
recording::ros::OccupancyGrid occupancy(const nav::FloorMap& floor, Time stamp);
recording::ros::CanFrame can_frame(const hal::CanFrame& frame, Time stamp);

}  // namespace headway::runtime
