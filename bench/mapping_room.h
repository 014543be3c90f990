// A room that is known to the last millimetre, and what a stereo camera in a robot's head sees of it: the
// common ground of the map's benchmarks. Boxes, a ball, and a pole 3 cm thick, all off the voxels' raster.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "vision/range_view.h"

namespace headway::bench {

class Room {
 public:
  Room();

  /// Distance [m] in units of `direction` to the first surface; the origin lies in the room's air.
  double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  /// Distance [m] from the nearest surface, negative inside of solids and walls.
  double clearance(const Eigen::Vector3d& point) const;
  /// Whether a voxel with this centre and edge [m] may hold the pole's surface, away from its ends.
  bool on_pole(const Eigen::Vector3d& centre, double edge) const;

 private:
  Eigen::AlignedBox3d walls_;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

/// How the camera errs.
struct StereoNoise {
  double blur = 0;      ///< [px] noise is independent per pixel, or has passed a Gaussian of this sigma
  double outliers = 0;  ///< share of pixels with any distance between 0.8 and 5 m
  std::uint64_t seed = 1;
};

/// Where the head is, and its camera.
struct HeadCamera {
  int width = 640, height = 480;
  double field = 60;                      ///< horizontal [deg]
  Eigen::Vector3d head{-2.0, 0.03, 1.5};  ///< the point about which it pans and tilts [m]
};

struct PosedView {
  vision::RangeView view;
  Eigen::Isometry3d map_from_camera;
};

inline constexpr double kNearest = 0.5, kFarthest = 5.0;  ///< what a view is trusted for [m]

/// Nine directions of gaze, three by three. Disparities err by 0.25 px, are rounded to 1/16 px, and every
/// twentieth is missing. The same bytes on every machine with the same mathematics library.
std::vector<PosedView> look_around(const Room& room, const HeadCamera& camera, const StereoNoise& noise);

}  // namespace headway::bench
