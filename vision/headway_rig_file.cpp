#include <cmath>
#include <fstream>
#include <numbers>

#include <fmt/format.h>

#include "config/yaml_limits.h"
#include "vision/calibration_file.h"
#include "vision/rig_files.h"

namespace headway::vision {

namespace fs = std::filesystem;
using config::Section;

namespace {

constexpr double kRadian = std::numbers::pi / 180;

const char* name_of(LensModel lens) {
  switch (lens) {
    case LensModel::kRadialTangential:
      return "radial_tangential";
    case LensModel::kRational:
      return "rational";
    case LensModel::kEquidistant:
      return "equidistant";
  }
  return "";
}

LensModel lens_of(const Section& section) {
  const std::string name =
      section.choice_or("lens", "radial_tangential", {"radial_tangential", "rational", "equidistant"});
  return name == "rational"      ? LensModel::kRational
         : name == "equidistant" ? LensModel::kEquidistant
                                 : LensModel::kRadialTangential;
}

// `whole`: the file's mapping, for both images are of one size.
CameraIntrinsics camera_from(const Section& section, const Section& whole) {
  CameraIntrinsics c;
  set_size(c, whole, "size");
  const auto focal = section.numbers("focal", 2, {1, 1e6, "px"});
  const auto centre = section.numbers("centre", 2, {0, 16384, "px"});
  c.fx = focal[0], c.fy = focal[1], c.cx = centre[0], c.cy = centre[1];
  c.lens = lens_of(section);
  const std::size_t count = coefficients_of(c).size();
  if (const auto d = section.numbers_if("distortion", count, {-1000, 1000}))
    set_lens(c, c.lens, *d, section, "distortion");
  return c;
}

Eigen::Isometry3d pose_from(const Section& section) {
  const auto t = section.numbers("translation", 3, {-1, 1, "m"});
  const auto r =
      section.numbers_if("rotation_deg", 3, {-180, 180, "deg"}).value_or(std::vector<double>{0, 0, 0});
  const Eigen::Vector3d turn = kRadian * Eigen::Vector3d(r[0], r[1], r[2]);
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  if (turn.norm() > 0) out.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  out.translation() << t[0], t[1], t[2];
  return out;
}

// A YAML text in single quotes, which takes any character but a line break.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : config::one_line(text)) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

std::string camera_text(const CameraIntrinsics& c) {
  return fmt::format(
      "  focal: [{}, {}]  # fx, fy [px]\n  centre: [{}, {}]\n  lens: {}\n  distortion: [{}]  # {}\n", c.fx,
      c.fy, c.cx, c.cy, name_of(c.lens), fmt::join(coefficients_of(c), ", "), coefficient_names(c.lens));
}

std::string rig_text(const StereoRig& rig) {
  const Eigen::Vector3d t = rig.right_from_left.translation();
  const Eigen::AngleAxisd turn(rig.right_from_left.linear());
  const Eigen::Vector3d r = turn.angle() / kRadian * turn.axis();
  return fmt::format("name: {}\nsize: [{}, {}]  # width, height [px]\n",
                     quoted(rig.name.empty() ? "rig" : rig.name), rig.left.width, rig.left.height) +
         "left:\n" + camera_text(rig.left) + "right:\n" + camera_text(rig.right) +
         fmt::format(
             "right_from_left:  # maps points of the left optical frame (z forward, x right, y down)\n"
             "  translation: [{}, {}, {}]  # [m]\n"
             "  rotation_deg: [{}, {}, {}]  # axis times angle\n",
             t.x(), t.y(), t.z(), r.x(), r.y(), r.z()) +
         fmt::format("nearest: {}  # [m]\nfarthest: {}\ndisparity_sigma: {}  # [px]\n", rig.nearest,
                     rig.farthest, rig.disparity_sigma);
}

}  // namespace

StereoRig rig_from(const Section& section) {
  StereoRig rig;
  rig.name = section.text("name");
  const Section left = section.section("left"), right = section.section("right");
  rig.left = camera_from(left, section);
  rig.right = camera_from(right, section);
  rig.right_from_left = pose_from(section.section("right_from_left"));
  rig.nearest = section.number("nearest", {0.05, 100, "m"});
  rig.farthest = section.number("farthest", {0.05, 1000, "m"});
  rig.disparity_sigma = section.number_or("disparity_sigma", rig.disparity_sigma, {0.01, 10, "px"});
  require_usable_at({left, right, section, "size", "focal", "centre", "distortion", "right_from_left"}, rig);
  return rig;
}

void write_rig(const StereoRig& rig, const fs::path& file) {
  require_usable(rig);
  write_text(rig_text(rig), file);
}

}  // namespace headway::vision
