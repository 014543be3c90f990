// The sweep of a view over the map: projects voxels into the range image, whole bricks at a time where that
// settles them, and adds what each voxel learns.
#pragma once

#include <Eigen/Geometry>

#include "hal/time.h"
#include "nav/integrate.h"
#include "nav/range_samples.h"
#include "nav/voxel_map.h"
#include "nav/voxel_marks.h"

namespace headway::nav {

/// What a view says of the space before the camera.
struct SeenSpace {
  const RangeSamples& samples;
  const SampleClasses& classes;
  VoxelMarks& marks;         ///< used up
  LogOdds least_hit;         ///< for a voxel that holds a measured point, however wide sigma is
  LogOdds least_before_hit;  ///< what a hit leaves of an older past before it counts
  Eigen::Isometry3d map_from_camera;
};

/// Adds it to the map, and to hits, misses, first_seen and bricks_changed of `stats`.
void update_bricks(const SeenSpace& seen, Time stamp, VoxelMap& map, IntegrationStats& stats);

}  // namespace headway::nav
