// A room of planes and boxes with exact depths and distances: the oracle for the map's tests.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <random>
#include <vector>

#include "vision/range_view.h"

namespace headway::nav {

struct SolidBox {
  Eigen::Vector3d lowest, highest;
};

/// A rectangular room seen from inside, with solid boxes standing in it; map frame, floor at z = 0.
struct SyntheticRoom {
  SolidBox walls{{-2.61, -2.42, 0.0}, {2.63, 2.44, 2.51}};
  std::vector<SolidBox> solids;

  /// Table, crate, shelf, and a pole 3 cm thick.
  static SyntheticRoom furnished();

  /// Distance [m] along `direction` to the first surface; the origin lies in the room's air.
  double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  /// Distance [m] from the nearest surface, negative inside of solids and walls.
  double clearance(const Eigen::Vector3d& point) const;
};

/// How the camera errs.
struct Noise {
  double disparity_sigma = 0;  ///< [px]
  int correlation = 1;         ///< [px] noise is the same within about so many pixels
  double largest = 10;         ///< noise is cut off at so many sigma
  double outliers = 0;         ///< share of pixels with any depth within the range
  std::uint64_t seed = 1;
};

/// A stereo camera of the given size, field and baseline 0.144 m.
vision::PinholeCamera camera_of(int width, int height, double horizontal_field);

/// The pose of a camera at `position` that looks along yaw [rad], `down` [rad] below the horizon.
Eigen::Isometry3d camera_pose(const Eigen::Vector3d& position, double yaw, double down);

/// What the camera sees. `sigma` [px] is what it says its disparity's standard deviation is.
vision::RangeView look(const SyntheticRoom& room, const vision::PinholeCamera& camera,
                       const Eigen::Isometry3d& map_from_camera, const Noise& noise = {}, double sigma = 0.3,
                       double near = 0.5, double far = 5.0);

/// Uniform in [0, 1), and standard normal; the same on every machine.
double uniform(std::mt19937_64& random);
double normal(std::mt19937_64& random);

}  // namespace headway::nav
