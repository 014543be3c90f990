#include <cmath>

#include <fmt/format.h>

#include "vision/calibration_file.h"
#include "vision/rectify.h"
#include "vision/rig_files.h"

namespace headway::vision {

namespace fs = std::filesystem;
using config::Section;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

LensModel lens_of(const Section& section) {
  const std::string model = section.choice(
      "distortion_model", {"plumb_bob", "rational_polynomial", "equidistant", "fisheye", "none"});
  return model == "rational_polynomial"                 ? LensModel::kRational
         : model == "equidistant" || model == "fisheye" ? LensModel::kEquidistant
                                                        : LensModel::kRadialTangential;
}

const char* name_of(LensModel lens) {
  switch (lens) {
    case LensModel::kRadialTangential:
      return "plumb_bob";
    case LensModel::kRational:
      return "rational_polynomial";
    case LensModel::kEquidistant:
      return "equidistant";
  }
  return "";
}

struct CameraInfo {
  CameraIntrinsics camera;
  Matrix3d rectified_from_raw;
  std::vector<double> projection;  // 3 x 4
};

CameraInfo info_from(const Section& section) {
  CameraInfo info;
  CameraIntrinsics& c = info.camera;
  c.width = section.integer("image_width", {16, 16384, "px"});
  c.height = section.integer("image_height", {16, 16384, "px"});
  const auto k = matrix_of(section, "camera_matrix", 3, 3);
  c.fx = k[0], c.fy = k[4], c.cx = k[2], c.cy = k[5];
  set_lens(c, lens_of(section), vector_of(section, "distortion_coefficients", 14), section,
           "distortion_coefficients");
  info.rectified_from_raw =
      rotation_from(matrix_of(section, "rectification_matrix", 3, 3), section, "rectification_matrix");
  info.projection = matrix_of(section, "projection_matrix", 3, 4);
  return info;
}

// The place of the right camera on the x axis of the rectified left one [m], from -focal * baseline.
double baseline_of(const CameraInfo& left, const CameraInfo& right, const Section& left_file,
                   const Section& right_file) {
  const std::string_view key = "projection_matrix";
  const double focal = right.projection[0], shift = right.projection[3];
  if (left.projection[3] != 0)
    left_file.fail(key,
                   fmt::format("its [0, 3] is {}, expected 0 of the left camera; are left and right swapped?",
                               left.projection[3]));
  if (!(shift < 0))
    right_file.fail(key,
                    fmt::format("its [0, 3] is {}, expected less than 0 of the right camera: minus focal "
                                "length [px] times baseline [m]; are left and right swapped?",
                                shift));
  if (!(focal > 1) || std::abs(focal - left.projection[0]) > 1e-3 * focal)
    right_file.fail(key, fmt::format("its focal length is {}, expected that of the left camera, {}", focal,
                                     left.projection[0]));
  return -shift / focal;
}

std::string matrix_text(const char* key, int rows, int columns, const std::vector<double>& data) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", key, rows, columns,
                     fmt::join(data, ", "));
}

std::string info_text(const char* name, const CameraIntrinsics& c, const Matrix3d& r, const RectifiedRig& rig,
                      double shift, double centre) {
  const double f = rig.camera.focal;
  const auto k = coefficients_of(c);
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", c.width, c.height, name) +
         matrix_text("camera_matrix", 3, 3, {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1}) +
         fmt::format("distortion_model: {}\n", name_of(c.lens)) +
         matrix_text("distortion_coefficients", 1, static_cast<int>(k.size()), k) +
         matrix_text("rectification_matrix", 3, 3,
                     {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)}) +
         matrix_text("projection_matrix", 3, 4, {f, 0, centre, shift, 0, f, rig.camera.cy, 0, 0, 0, 1, 0});
}

}  // namespace

StereoRig rig_from_camera_infos(const Section& left_file, const Section& right_file,
                                const RigDefaults& defaults) {
  const CameraInfo left = info_from(left_file), right = info_from(right_file);
  StereoRig rig;
  rig.name = left_file.file();
  rig.left = left.camera, rig.right = right.camera;
  rig.nearest = defaults.nearest, rig.farthest = defaults.farthest;
  const double baseline = baseline_of(left, right, left_file, right_file);
  const Matrix3d raw_from_rectified = right.rectified_from_raw.transpose();
  rig.right_from_left.linear() = raw_from_rectified * left.rectified_from_raw;
  rig.right_from_left.translation() = raw_from_rectified * Vector3d(-baseline, 0, 0);
  require_usable_at({left_file, right_file, right_file, "image_width", "camera_matrix", "camera_matrix",
                     "distortion_coefficients", "projection_matrix"},
                    rig);
  return rig;
}

void write_camera_info(const StereoRig& rig, const fs::path& left, const fs::path& right) {
  const Rectifier rectifier(rig);
  const RectifiedRig& r = rectifier.rig();
  const double shift = -r.camera.focal * r.baseline;
  write_text(info_text("left", rig.left, rectifier.rectified_from_left().linear(), r, 0, r.camera.cx), left);
  write_text(info_text("right", rig.right, rectifier.rectified_from_right().linear(), r, shift,
                       r.camera.cx + r.disparity_offset),
             right);
}

}  // namespace headway::vision
