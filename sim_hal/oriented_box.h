// A box in any attitude (a part of a swaying robot) against the upright solids of the world.
#pragma once

#include <Eigen/Geometry>

#include "sim_hal/solid.h"

namespace headway::sim {

struct OrientedBox {
  Eigen::Isometry3d map_from_box = Eigen::Isometry3d::Identity();  ///< centred on the origin of its frame
  Eigen::Vector3d size{1, 1, 1};                                   ///< full lengths along x, y, z [m]
};

/// Do they share volume? Exact: the box is cut to the solid's heights, and its outline on the floor then
/// compared with the solid's. No heap, no exceptions.
bool overlap(const OrientedBox& box, const Solid& solid) noexcept;

}  // namespace headway::sim
