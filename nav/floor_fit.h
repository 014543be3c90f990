// The floor as one view shows it: a plane through the surface near the robot's feet, or why there is none.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "vision/range_view.h"

namespace headway::nav {

struct FloorFitConfig {
  double range = 3.0;  ///< rays that meet the floor nearer than this to the camera's foot take part [m]
  double widest_tilt = 0.035;  ///< what leans more is a ramp, or no floor [rad]
  double greatest_height =
      0.04;                ///< what lies so far above or below the robot's feet is no floor of theirs [m]
  int least_points = 300;  ///< of those looked at; fewer tell nothing

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

/// z = height + slope . ((x, y) - foot), in the map's frame.
struct FloorPlane {
  Eigen::Vector2d foot{0, 0};                            ///< of the camera [m]
  double height = 0;                                     ///< at the foot [m]
  Eigen::Vector2d slope{0, 0};                           ///< along x and y
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (height, slope)
  std::size_t points = 0;                                ///< that lie on it
};

enum class FloorSight {
  kPlane,      ///< the floor is seen
  kTooFew,     ///< too few points near enough and low enough
  kScattered,  ///< they lie on no single surface
  kNotLowest,  ///< other points lie below the surface that most lie on
  kTooSteep,   ///< the surface leans too much
  kTooHigh,    ///< or lies too high or low
};

struct FloorFit {
  FloorSight sight = FloorSight::kTooFew;
  FloorPlane plane;  ///< also where it was refused, as far as it was found
  explicit operator bool() const { return sight == FloorSight::kPlane; }
};

/// Fits floor planes, and keeps the memory that it needs for that.
class FloorFitter {
 public:
  /// Throws InputError as FloorFitConfig::validate.
  explicit FloorFitter(const FloorFitConfig& config = {});

  /// By least squares over the points near the floor, those off the plane left out step by step. z = 0 is the
  /// floor under the robot but for errors of `map_from_view`.
  FloorFit fit(const vision::RangeView& view, const Eigen::Isometry3d& map_from_view);

 private:
  /// A pixel whose ray meets the floor in reach. In inverse depth planes are linear and noise is the same
  /// whatever was measured, so that nothing prefers what came out too near:
  ///   row . (height, slope) = right
  struct Point {
    Eigen::Vector3d row;
    double right;
    double sigma;        ///< of `right`
    double floor_depth;  ///< to the floor as it is assumed, which makes heights [m] of what is left over
  };
  static double above(const FloorPlane& plane, const Point& point);
  void take(const vision::RangeView& view, const Eigen::Isometry3d& map_from_view);
  FloorSight judge(const FloorPlane& plane) const;

  FloorFitConfig config_;
  std::vector<Point> points_;
  std::size_t lower_ = 0;  ///< points below all that could be floor
};

}  // namespace headway::nav
