// How well a map agrees with the room it is of.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "nav/voxel_map.h"
#include "synthetic_room.h"

namespace headway::nav {

/// Shares of 1.
struct MapScore {
  double surface_occupied = 0;  ///< of the voxels that three or more pixels hit
  double surface_emptied = 0;
  double air_empty = 0;      ///< of voxels in view, 10 cm and more from every surface
  double air_occupied = 0;   ///< of the same
  double solid_emptied = 0;  ///< of voxels a voxel and more below a surface
  double pole_occupied = 0;  ///< of voxels that a pixel hit on the 3 cm pole of SyntheticRoom::furnished
};

/// `poses`: where the views were taken from.
MapScore score(const VoxelMap& map, const SyntheticRoom& room, const vision::PinholeCamera& camera,
               const std::vector<Eigen::Isometry3d>& poses);

}  // namespace headway::nav
