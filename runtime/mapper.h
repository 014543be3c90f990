// The part of the frame's work that turns a look into knowledge: voxel map, then floor map.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>

#include "hal/pose2.h"
#include "nav/cold_store.h"
#include "nav/floor_map.h"
#include "nav/floor_projection.h"
#include "nav/integrate.h"
#include "nav/passing_obstacles.h"
#include "nav/raised_floor.h"
#include "nav/voxel_map.h"
#include "vision/range_view.h"

namespace headway::runtime {

struct MapperConfig {
  nav::VoxelMapConfig voxels;  ///< the box of all that is mapped
  /// Edge [m] of the square around the robot that is kept at hand; what lies outside is kept aside and comes
  /// back with the robot. 0, or more than the box: all of the box.
  double window = 0;
  nav::IntegrationConfig integration;
  nav::FloorMapConfig floor;
  nav::RaisedFloorConfig raised_floor;
  nav::StartArea start_area;

  /// From where to where things are obstacles: raised floor counts from the trip height on.
  nav::FloorMapConfig obstacle_heights() const {
    nav::FloorMapConfig heights = floor;
    if (raised_floor.trip_height > 0)
      heights.floor_tolerance = std::min(heights.floor_tolerance, raised_floor.trip_height);
    return heights;
  }
};

/// What is known of the world. The operator vouches for the area around `start`, where the head cannot look.
class Mapper {
 public:
  Mapper(const MapperConfig& config, const Pose2& start);

  /// Takes over what is known from before, ahead of the first look. It counts as seen at no time, so no step
  /// commits there until it has been looked at again. Throws InputError when its voxels have another size.
  void restore(const nav::ColdMap& known);

  /// Takes in one look; `stamp` is its exposure.
  nav::IntegrationStats integrate(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera,
                                  const Eigen::Isometry3d& map_from_chest, Time stamp);
  /// Projects on the floor what has changed in the map.
  void project();

  /// Of the window.
  const nav::VoxelMap& voxels() const { return voxels_; }
  /// Of the whole box; outside of the window as it was last known.
  const nav::FloorMap& floor() const { return floor_; }
  /// What came onto the floor, and what was last seen standing where.
  const nav::PassingObstacles& passing() const { return passing_; }
  /// What has left the window.
  const nav::ColdMap& aside() const { return aside_.map(); }
  /// All that is known, in the window and aside.
  nav::ColdMap everything() const;
  /// The bricks of the whole box.
  nav::BrickRange box() const { return nav::bricks_in(config_.voxels); }

 private:
  void follow(const Eigen::Vector3d& robot);
  void show_all_to_the_window();

  MapperConfig config_;
  Pose2 start_;
  bool at_start_ = true;  ///< the robot still stands where it began
  nav::VoxelMap voxels_;
  nav::ColdStore aside_;
  nav::Integrator integrator_;
  nav::RaisedFloor raised_;
  nav::FloorProjection projection_;
  nav::FloorMap floor_;
  nav::PassingObstacles passing_;
};

}  // namespace headway::runtime
