#include "hal/head_kinematics.h"

#include <cmath>

namespace headway::hal {

HeadAngles HeadKinematics::look_at(const Eigen::Vector3d& point_in_chest) const {
  HeadAngles a;
  // Newton's method on the two image errors would do as well; this fixed point settles in a few rounds
  // because the joint offsets are small beside the distance.
  for (int round = 0; round < 10; ++round) {
    const Eigen::Isometry3d camera = chest_from_camera(a);
    const Eigen::Vector3d ray = point_in_chest - camera.translation();
    const Eigen::Vector3d axis = camera.linear().col(2);
    a.pan += std::atan2(ray.y(), ray.x()) - std::atan2(axis.y(), axis.x());
    a.pan = std::remainder(a.pan, 2 * M_PI);
    a.tilt += std::atan2(-ray.z(), std::hypot(ray.x(), ray.y())) -
              std::atan2(-axis.z(), std::hypot(axis.x(), axis.y()));
  }
  return a;
}

Eigen::Matrix3d body_from_optical(double down) {
  Eigen::Matrix3d r;
  r << 0, 0, 1,  //
      -1, 0, 0,  //
      0, -1, 0;
  return Eigen::AngleAxisd(down, Eigen::Vector3d::UnitY()) * r;
}

}  // namespace headway::hal
