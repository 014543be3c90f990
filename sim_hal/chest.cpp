#include "sim_hal/chest.h"

#include <cmath>

#include "hal/error.h"

namespace headway::sim {

void ChestConfig::validate() const {
  if (!(height > 0.1 && height < 3)) throw InputError("chest.height must lie between 0.1 and 3 m");
  if (!(std::abs(ahead_of_com) < 1)) throw InputError("chest.ahead_of_com must lie within 1 m");
  if (!(std::abs(roll_per_acceleration) < 0.1 && std::abs(pitch_per_acceleration) < 0.1)) {
    throw InputError("chest: the sway per acceleration must lie within 0.1 rad per m/s^2");
  }
}

Eigen::Isometry3d chest_pose(const ChestConfig& config, const Eigen::Vector2d& com,
                             const Eigen::Vector2d& acceleration, double yaw) {
  using Eigen::AngleAxisd, Eigen::Vector2d, Eigen::Vector3d;
  const Vector2d along(std::cos(yaw), std::sin(yaw)), aside(-std::sin(yaw), std::cos(yaw));
  const Vector2d place = com + config.ahead_of_com * along;
  const double roll = config.roll_per_acceleration * acceleration.dot(aside);
  const double pitch = -config.pitch_per_acceleration * acceleration.dot(along);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << place, config.height;
  pose.linear() = (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
                   AngleAxisd(roll, Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

}  // namespace headway::sim
