// What the rig can see as triangles for viewers, in the frame of its views.
#pragma once

#include "operator/messages.h"
#include "vision/polytope.h"
#include "vision/rig.h"
#include "vision/stereo.h"

namespace headway::app {

/// Namespace "rig": all that a pair can show; "5 mm", "10 mm", ...: where a point is at least so precise.
remote::ros::MarkerArray field_markers(const vision::StereoRig& rig, const vision::VisionConfig& config);

/// The faces of a bounded polytope, three points a triangle, seen from outside in counter-clockwise order.
std::vector<Eigen::Vector3d> triangles(const vision::Polytope& polytope);

}  // namespace headway::app
