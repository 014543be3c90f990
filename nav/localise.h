// How far the robot is off where its odometry says: a range view is aligned with the surfaces of the map.
//
// A walking humanoid's odometry drifts over the floor and about the vertical; its height and tilt it knows
// from its feet and from gravity. So steep surfaces alone tell of the drift, point to plane.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "nav/surface_points.h"
#include "nav/view_patches.h"
#include "nav/voxel_map.h"

namespace headway::nav {

struct LocaliseConfig {
  int fewest_patches = 60;      ///< of a view that meet surfaces of the map
  double least_known = 0.25;    ///< and this share of all its patches: what is hardly known is known badly
  double least_share = 0.5;     ///< of them that agree with it
  double largest_misfit = 1.5;  ///< Alignment::misfit; a view with more is refused
  double gate = 4;              ///< patches farther than so many sigma from their plane do not count
  double largest_chi2 = 16.3;   ///< of a change against what the believed pose may be off: 0.999 of 3 degrees
  double steepest = 0.5;        ///< |z| of a normal that tells of the drift
  /// A direction is determined when the surfaces that face it have at least this share of the whole weight,
  /// and more than the errors of their normals could feign.
  double least_facing = 0.005;
  double place_sigma = 0.002;  ///< of a plane's place, however often it was measured [m]
  // What all patches of a view err alike, by the neck, the calibration and the matcher:
  double shift_sigma = 0.003;  ///< along x and y [m]
  double turn_sigma = 0.002;   ///< about the vertical [rad]
  int iterations = 15;         ///< at most

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

enum class Aligned : std::uint8_t {
  kWhole,         ///< the geometry determines all of it
  kPartly,        ///< in some directions only: a wall, a corridor
  kFewPatches,    ///< too little of the view meets what the map knows
  kUndetermined,  ///< in no direction
  kMisfit,        ///< too few patches agree, or less well than their sigma says
  kTooFar,        ///< the change is larger than the believed pose can be off
};
const char* name(Aligned aligned);

/// Of the robot's pose: first turned by z about the vertical through `about`, then shifted by (x, y).
struct Alignment {
  Aligned aligned = Aligned::kFewPatches;
  Eigen::Vector2d about{0, 0};                            ///< [m]
  Eigen::Vector3d change = Eigen::Vector3d::Zero();       ///< x, y [m], yaw [rad]
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< inverse covariance; 0 where undetermined
  std::size_t patches = 0, matched = 0;                   ///< of the view; that agree with the map
  int determined = 0;                                     ///< directions of the three
  double misfit = 1;  ///< median residual over what its sigma lets expect, at least 1; scales the information

  explicit operator bool() const { return aligned == Aligned::kWhole || aligned == Aligned::kPartly; }
  /// corrected_from_believed, of points of the map frame. The identity where there is none.
  Eigen::Isometry3d correction() const;
};

/// Keeps its memory between views. The same views in the same order give the same corrections.
class Localiser {
 public:
  explicit Localiser(const LocaliseConfig& config = {});
  ~Localiser();
  Localiser(Localiser&&) noexcept;
  Localiser& operator=(Localiser&&) noexcept;

  /// Aligns patches seen from `map_from_camera` as believed by a robot at `about` [m], whose x, y and yaw
  /// have the covariance `believed` [m^2, m rad, rad^2].
  Alignment align(const VoxelMap& map, const SurfacePoints& surfaces, std::span<const Patch> patches,
                  const Eigen::Isometry3d& map_from_camera, const Eigen::Vector2d& about,
                  const Eigen::Matrix3d& believed);

 private:
  struct Scratch;
  LocaliseConfig config_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace headway::nav
