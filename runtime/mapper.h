// The part of the frame's work that turns a look into knowledge: voxel map, then floor map.
#pragma once

#include <Eigen/Geometry>

#include "hal/pose2.h"
#include "nav/floor_map.h"
#include "nav/integrate.h"
#include "nav/voxel_map.h"
#include "vision/range_view.h"

namespace headway::runtime {

struct MapperConfig {
  nav::VoxelMapConfig voxels;
  nav::IntegrationConfig integration;
  nav::FloorMapConfig floor;
  nav::StartArea start_area;
};

/// What is known of the world. The operator vouches for the area around `start`, where the head cannot look.
class Mapper {
 public:
  Mapper(const MapperConfig& config, const Pose2& start);

  /// Takes in one look; `stamp` is its exposure.
  nav::IntegrationStats integrate(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera,
                                  const Eigen::Isometry3d& map_from_chest, Time stamp);
  /// Projects the map on the floor again.
  void project();

  const nav::VoxelMap& voxels() const { return voxels_; }
  const nav::FloorMap& floor() const { return floor_; }

 private:
  MapperConfig config_;
  Pose2 start_;
  bool at_start_ = true;  ///< the robot still stands where it began
  nav::VoxelMap voxels_;
  nav::Integrator integrator_;
  nav::FloorMap floor_;
};

}  // namespace headway::runtime
