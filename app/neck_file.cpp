#include "app/neck_file.h"

#include <cmath>

#include <fmt/format.h>

#include "hal/angle.h"

namespace headway::app {

std::string neck_text(const hal::HeadKinematics& neck, Duration camera_time_offset) {
  const Eigen::Matrix3d camera = neck.tilt_from_camera.linear();
  const Eigen::Vector3d axis = camera.col(2), place = neck.tilt_from_camera.translation();
  const double down = std::atan2(-axis.z(), axis.x());
  const Eigen::AngleAxisd rest(Eigen::Matrix3d(camera * hal::body_from_optical(down).transpose()));
  const Eigen::Vector3d turn = rest.angle() / kDegree * rest.axis();
  std::string text = "neck:\n";
  text += fmt::format("  tilt_from_camera: [{:.6f}, {:.6f}, {:.6f}]\n", place.x(), place.y(), place.z());
  text += fmt::format("  camera_down_deg: {:.6f}\n", down / kDegree);
  text += fmt::format("  camera_turn_deg: [{:.6f}, {:.6f}, {:.6f}]\n", turn.x(), turn.y(), turn.z());
  text += fmt::format("  pan_zero_deg: {:.6f}\n", neck.zero.pan / kDegree);
  text += fmt::format("  tilt_zero_deg: {:.6f}\n", neck.zero.tilt / kDegree);
  text += fmt::format("  camera_time_offset_ms: {:.3f}\n", 1000 * to_seconds(camera_time_offset));
  return text;
}

}  // namespace headway::app
