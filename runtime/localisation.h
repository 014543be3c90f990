// Keeps the odometry's drift by looking: each view is aligned with the map before it becomes part of it.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "hal/pose2.h"
#include "nav/localise.h"
#include "nav/passing_obstacles.h"
#include "nav/surface_points.h"
#include "nav/view_patches.h"
#include "nav/voxel_map.h"
#include "runtime/drift.h"
#include "runtime/glance.h"
#include "vision/range_view.h"

namespace headway::runtime {

struct LocalisationConfig {
  bool use = true;  ///< false: odometry is taken for the truth
  nav::PatchConfig patches;
  nav::LocaliseConfig localise;
  /// What lies lower says nothing [m]: where a wall meets the floor, points of either lie in the other's
  /// planes.
  double lowest = 0.12;
  DriftConfig drift;
  GlanceConfig glance;
  // Standard deviations of where the robot is set up in a map that is known from before. A place farther off
  // than four of them is a chance match: the map is of elsewhere, or the robot stands elsewhere.
  double start_shift = 0.05;  ///< [m]
  double start_turn = 0.035;  ///< [rad]
  // Plans are made again from the corrected place when it has moved farther than this:
  double steady_shift = 0.01;  ///< [m]
  double steady_turn = 0.01;   ///< [rad]
};

/// Views with a result, by what it was.
struct LocalisationCounters {
  std::uint64_t whole = 0, partly = 0, refused = 0;
};

/// Aligns, filters and remembers, frame by frame. Without a map from before, map and odometry are one until
/// the robot moves.
class Localisation {
 public:
  /// `map` must outlive this.
  Localisation(const LocalisationConfig& config, const nav::VoxelMap& map);

  /// Takes over the surfaces of a map that is known from before, ahead of the first view. Until views have
  /// told where in it the robot stands, placed() is false, and they must not become part of it. They may take
  /// that back while the robot has not walked.
  void restore(const nav::SurfacePoints& surfaces);
  bool placed() const { return placed_; }

  /// Aligns a view with the map. `odom_from_view` and `odom_from_chest` at its exposure, `stamp`. What moves,
  /// by `passing`, is left out, and what is too low.
  void see(const vision::RangeView& view, const Eigen::Isometry3d& odom_from_view,
           const Eigen::Isometry3d& odom_from_chest, Time stamp, const nav::PassingObstacles& passing);
  /// Remembers the surfaces of the view seen last, which is part of the map now.
  void learn();

  /// The newest correction.
  Pose2 map_from_odom() const { return drift_.map_from_odom(); }
  /// The correction that plans rest on: it stays until the newest one moves the robot noticeably.
  const Pose2& steady() const { return steady_; }
  const Drift& drift() const { return drift_; }
  /// Of the view seen last; empty when it was not aligned.
  const nav::Alignment& alignment() const { return alignment_; }
  const LocalisationCounters& counters() const { return counters_; }
  /// What views are aligned with: to be saved with the map.
  const nav::SurfacePoints& surfaces() const { return surfaces_; }

 private:
  void leave_out(const nav::PassingObstacles& passing);
  void count();
  bool found_place() const;
  bool near_start() const;

  LocalisationConfig config_;
  bool placed_ = true, restored_ = false;
  std::optional<Pose2> start_;  ///< where the robot stood when it saw first, in the odometry frame
  const nav::VoxelMap& map_;
  nav::SurfacePoints surfaces_;
  nav::Localiser localiser_;
  Drift drift_;
  std::vector<nav::Patch> patches_;
  Eigen::Isometry3d odom_from_view_ = Eigen::Isometry3d::Identity();
  nav::Alignment alignment_;
  Pose2 steady_;
  LocalisationCounters counters_;
};

}  // namespace headway::runtime
