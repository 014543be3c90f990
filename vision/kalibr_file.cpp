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
  const std::string model = section.choice("distortion_model", {"radtan", "equidistant", "none"});
  if (model == "none") return c;
  set_lens(c, model == "radtan" ? LensModel::kRadialTangential : LensModel::kEquidistant,
           section.numbers("distortion_coeffs", 4, {-1000, 1000}), section, "distortion_coeffs");
  return c;
}

}  // namespace

StereoRig rig_from_kalibr(const Section& chain, const RigDefaults& defaults) {
  const Section left = chain.section("cam0"), right = chain.section("cam1");
  StereoRig rig;
  rig.name = chain.file();
  rig.left = camera_from(left), rig.right = camera_from(right);
  rig.right_from_left = transform_from(right.matrix("T_cn_cnm1", 4, 4, {-1000, 1000}), right, "T_cn_cnm1");
  rig.nearest = defaults.nearest, rig.farthest = defaults.farthest;
  require_usable_at(
      {left, right, right, "resolution", "intrinsics", "intrinsics", "distortion_coeffs", "T_cn_cnm1"}, rig);
  return rig;
}

}  // namespace headway::vision
