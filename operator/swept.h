// The floor that the body sweeps along a way, with the clearance that is kept around it.
#pragma once

#include <vector>

#include "nav/body_outline.h"
#include "runtime/recording/ros_messages.h"

namespace headway::remote {

/// Cells of the grid that the outline touches at any pose of the way, or between two of them: 100, all others
/// 0. Only the rectangle that holds them; without a way it has no cells.
recording::ros::OccupancyGrid swept_floor(const std::vector<Pose2>& way, const nav::BodyOutline& outline,
                                          const nav::FloorGrid& grid, Time stamp);

}  // namespace headway::remote
