#include <algorithm>
#include <initializer_list>

#include <fmt/format.h>

#include "vision/calibration_file.h"
#include "vision/rig_formats.h"

namespace headway::vision {

using config::Section;

namespace {

// The first of these names that the file has, or the first of all, so that it is the one that is missing.
std::string name_in(const Section& section, std::initializer_list<std::string> names) {
  const auto found = std::find_if(names.begin(), names.end(), [&](const auto& n) { return section.has(n); });
  return found == names.end() ? *names.begin() : *found;
}

// One of our own keys must say what OpenCV's sample leaves out.
int extent(const Section& section, const std::string& key, int fallback) {
  if (fallback > 0 && !section.has(key)) return fallback;
  if (!section.has(key))
    section.fail("",
                 "does not say how large the images are (OpenCV's sample leaves it out); add image_width and "
                 "image_height [px]");
  return section.integer(key, {16, 16384, "px"});
}

void set_lens(CameraIntrinsics& c, const Section& section, const std::string& key) {
  std::vector<double> k = section.has(key) ? vector_of(section, key, 14) : std::vector<double>{};
  if (section.has("fisheye_model") && section.integer("fisheye_model", {0, 1}) == 1)
    return set_lens(c, LensModel::kEquidistant, k, section, key);
  if (k.size() > 8) {
    if (std::any_of(k.begin() + 8, k.end(), [](double term) { return term != 0; }))
      section.fail(key,
                   "has terms for a thin prism or a tilted sensor, expected at most k1 k2 p1 p2 k3 k4 k5 k6");
    k.resize(8);
  }
  set_lens(c, k.size() > 5 ? LensModel::kRational : LensModel::kRadialTangential, k, section, key);
}

// Which keys hold the values of camera 1 (left) or 2.
struct Keys {
  std::string matrix, distortion;
};

Keys keys_of(const Section& section, char n) {
  const std::string suffix(1, n);
  return {name_in(section, {"M" + suffix, "K" + suffix, "cameraMatrix" + suffix, "camera_matrix_" + suffix}),
          name_in(section, {"D" + suffix, "distCoeffs" + suffix, "distortion_coefficients_" + suffix})};
}

CameraIntrinsics camera_from(const Section& section, const Keys& keys, const RigDefaults& defaults) {
  CameraIntrinsics c;
  c.width = extent(section, "image_width", defaults.width);
  c.height = extent(section, "image_height", defaults.height);
  const auto m = matrix_of(section, keys.matrix, 3, 3);
  c.fx = m[0], c.fy = m[4], c.cx = m[2], c.cy = m[5];
  set_lens(c, section, keys.distortion);
  return c;
}

}  // namespace

StereoRig rig_from_opencv(const Section& intrinsics, const Section& extrinsics, const RigDefaults& defaults) {
  const Keys left = keys_of(intrinsics, '1'), right = keys_of(intrinsics, '2');
  StereoRig rig;
  rig.name = intrinsics.file();
  rig.left = camera_from(intrinsics, left, defaults);
  rig.right = camera_from(intrinsics, right, defaults);
  rig.right_from_left.linear() = rotation_from(matrix_of(extrinsics, "R", 3, 3), extrinsics, "R");
  const auto t = vector_of(extrinsics, "T", 3);
  if (t.size() != 3) extrinsics.fail("T", fmt::format("{} numbers, expected 3", t.size()));
  rig.right_from_left.translation() << t[0], t[1], t[2];
  rig.nearest = defaults.nearest, rig.farthest = defaults.farthest;
  if (const auto fault = fault_of(rig)) {
    const Keys& keys = fault->key.starts_with("right.") ? right : left;
    require_usable_at(
        {intrinsics, intrinsics, extrinsics, "image_width", keys.matrix, keys.matrix, keys.distortion, "T"},
        rig);
  }
  return rig;
}

}  // namespace headway::vision
