#include "vision/calibration_file.h"
#include "vision/rig_formats.h"

namespace headway::vision {

using config::Section;

namespace {

CameraIntrinsics camera_from(const Section& section) {
  CameraIntrinsics c;
  section.choice("camera_model", {"pinhole"});
  set_size(c, section, "resolution");
  const auto k = section.numbers("intrinsics", 4, {0, 1e6, "px"});
  c.fx = k[0], c.fy = k[1], c.cx = k[2], c.cy = k[3];
  const std::string model = section.choice("distortion_model", {"radial-tangential", "equidistant"});
  set_lens(c, model == "equidistant" ? LensModel::kEquidistant : LensModel::kRadialTangential,
           section.numbers("distortion_coefficients", 4, {-1000, 1000}), section, "distortion_coefficients");
  return c;
}

Eigen::Isometry3d body_from_sensor(const Section& section) {
  return transform_from(matrix_of(section, "T_BS", 4, 4), section, "T_BS");
}

}  // namespace

StereoRig rig_from_euroc(const Section& left, const Section& right, const RigDefaults& defaults) {
  StereoRig rig;
  rig.name = left.file();
  rig.left = camera_from(left), rig.right = camera_from(right);
  rig.right_from_left = body_from_sensor(right).inverse() * body_from_sensor(left);
  rig.nearest = defaults.nearest, rig.farthest = defaults.farthest;
  require_usable_at(
      {left, right, right, "resolution", "intrinsics", "intrinsics", "distortion_coefficients", "T_BS"}, rig);
  return rig;
}

}  // namespace headway::vision
