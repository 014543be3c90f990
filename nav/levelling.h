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
  std::uint64_t revised = 0;  ///< times that what was known gave way to what later views agreed on
};

/// A Kalman filter over the turn of the camera on the neck, about the axes of the view to the right and ahead
/// (about the third the floor tells nothing), and the height of the camera. Each is expected within the
/// limits of the fit and to stay, but for a slow walk; a view that disagrees clearly with what is known is no
/// floor.
///
/// Unless views go on to disagree with it and agree among each other: what they tell is gathered aside, and
/// believed once it rests on as many views in a row as what was known, or on ten seconds of them. So a robot
/// that was started on a slope, or whose head was knocked, finds its level again, and a ramp in passing
/// changes nothing.
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
  double tilt() const { return known_.state.x(); }
  double roll() const { return known_.state.y(); }
  /// Assumed height of the camera less the true one [m].
  double height() const { return known_.state.z(); }
  /// Of (tilt, roll, height).
  const Eigen::Matrix3d& covariance() const { return known_.covariance; }
  const LevellingCounters& counters() const { return counters_; }
  /// What became of the view looked at last.
  FloorSight sight() const { return sight_; }

 private:
  /// What views say that agree with each other: (tilt, roll, height).
  struct Belief {
    Eigen::Vector3d state = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    int views = 0;
    double seconds = 0;  ///< over which they were taken, pauses left out
  };
  struct Observation;

  static Observation observation(const FloorPlane& plane, const Eigen::Matrix3d& map_from_view,
                                 const Eigen::Vector3d& taken_out);
  Belief nothing_known() const;
  bool learn(const Observation& floor, double seconds);
  bool learn(const Observation& floor, double seconds, Belief& belief) const;
  bool within_limits(const Eigen::Vector3d& state) const;

  LevellingConfig config_;
  FloorFitter fitter_;
  Belief known_, rival_;
  Time last_{};
  bool begun_ = false;
  LevellingCounters counters_;
  FloorSight sight_ = FloorSight::kTooFew;
};

}  // namespace headway::nav
