// Takes what the head's tilt and height err out of the poses of views, by the floor that they show: a floor
// that seems to rise would stand in the way.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "hal/time.h"
#include "nav/floor_fit.h"

namespace headway::nav {

struct LevellingConfig {
  bool use = true;  ///< false: poses are taken as they come
  FloorFitConfig fit;
};

struct LevellingCounters {
  std::uint64_t fitted = 0;   ///< views whose floor was taken
  std::uint64_t unseen = 0;   ///< that showed too little of it
  std::uint64_t refused = 0;  ///< whose lowest surface was no floor, or not where the views before had it
};

/// A Kalman filter over the turn of the camera on the neck, about the axes of the view to the right and ahead
/// (about the third the floor tells nothing), and the height of the camera. Each is expected within the
/// limits of the fit and to stay, but for a slow walk; a view that disagrees clearly with what is known is no
/// floor.
class Levelling {
 public:
  /// Throws InputError as FloorFitConfig::validate.
  explicit Levelling(const LevellingConfig& config = {});

  /// Looks for the floor in a view taken at `stamp`, and returns the view's pose with all errors known by
  /// then taken out.
  Eigen::Isometry3d level(const vision::RangeView& view, const Eigen::Isometry3d& map_from_view, Time stamp);
  /// A pose with the errors known so far taken out.
  Eigen::Isometry3d levelled(const Eigen::Isometry3d& map_from_view) const;

  /// What the pose errs: true turn less assumed one, about the view's x axis (positive: truly looks
  /// higher) and z axis (positive: truly leans to the right) [rad].
  double tilt() const { return state_.x(); }
  double roll() const { return state_.y(); }
  /// Assumed height of the camera less the true one [m].
  double height() const { return state_.z(); }
  /// Of (tilt, roll, height).
  const Eigen::Matrix3d& covariance() const { return covariance_; }
  const LevellingCounters& counters() const { return counters_; }
  /// What became of the view looked at last.
  FloorSight sight() const { return sight_; }

 private:
  bool learn(const FloorPlane& plane, const Eigen::Matrix3d& map_from_view);
  bool within_limits(const Eigen::Vector3d& state) const;

  LevellingConfig config_;
  FloorFitter fitter_;
  Eigen::Vector3d state_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_;
  Time last_{};
  bool begun_ = false;
  LevellingCounters counters_;
  FloorSight sight_ = FloorSight::kTooFew;
};

}  // namespace headway::nav
