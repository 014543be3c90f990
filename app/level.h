// Which way is up, and where the floor is, when nobody has measured it: from the surfaces that were seen.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "vision/range_view.h"

namespace headway::app {

/// A small piece of surface, in the world's frame.
struct Surfel {
  Eigen::Vector3d point;   ///< [m]
  Eigen::Vector3d normal;  ///< of length one, towards the camera
};

/// Adds about `wanted` surfels of a view, where the surface is smooth.
void add_surfels(const vision::RangeView& view, const Eigen::Isometry3d& world_from_camera,
                 std::size_t wanted, std::vector<Surfel>& into);

/// The direction near `guess` (at most 50 degrees off) to which most surfaces lie level or upright: in rooms,
/// up. `guess` itself when there are too few surfaces.
Eigen::Vector3d estimate_up(const std::vector<Surfel>& surfels, const Eigen::Vector3d& guess);

struct FloorHeight {
  double height = 0;  ///< along up, in the world's frame [m]
  std::string how;    ///< a sentence for the report
};

/// The lowest level surface facing up that is large among those seen; else, the lowest that was seen.
FloorHeight estimate_floor(const std::vector<Surfel>& surfels, const Eigen::Vector3d& up);

/// Rotates `up` to z and the camera's forward direction to x, the camera's foot on the floor to the origin.
Eigen::Isometry3d map_from_world(const Eigen::Vector3d& up, double floor_height,
                                 const Eigen::Isometry3d& world_from_camera);

}  // namespace headway::app
