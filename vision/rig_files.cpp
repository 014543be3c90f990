#include "vision/rig_files.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include <fmt/format.h>

#include "config/yaml_limits.h"

namespace headway::vision {

namespace fs = std::filesystem;
using config::Section;

namespace {

constexpr double kRadian = std::numbers::pi / 180;

CameraIntrinsics camera_from(const Section& section, const std::vector<double>& size) {
  CameraIntrinsics c;
  c.width = static_cast<int>(size[0]), c.height = static_cast<int>(size[1]);
  const auto focal = section.numbers("focal", 2, {1, 1e6, "px"});
  const auto centre = section.numbers("centre", 2, {0, 16384, "px"});
  c.fx = focal[0], c.fy = focal[1], c.cx = centre[0], c.cy = centre[1];
  if (const auto d = section.numbers_if("distortion", 5, {-100, 100}))
    c.k1 = (*d)[0], c.k2 = (*d)[1], c.p1 = (*d)[2], c.p2 = (*d)[3], c.k3 = (*d)[4];
  return c;
}

Eigen::Isometry3d transform_from(const Section& section) {
  const auto t = section.numbers("translation", 3, {-1, 1, "m"});
  const auto r =
      section.numbers_if("rotation_deg", 3, {-180, 180, "deg"}).value_or(std::vector<double>{0, 0, 0});
  const Eigen::Vector3d turn = kRadian * Eigen::Vector3d(r[0], r[1], r[2]);
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  if (turn.norm() > 0) out.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  out.translation() << t[0], t[1], t[2];
  return out;
}

// Points at the key of the file that a fault of the whole rig has to do with.
void require_usable_at(const Section& section, const StereoRig& rig) {
  const auto fault = fault_of(rig);
  if (!fault) return;
  const std::size_t dot = fault->key.find('.');
  if (dot == std::string::npos) section.fail(fault->key, fault->what);
  section.section(fault->key.substr(0, dot)).fail(fault->key.substr(dot + 1), fault->what);
}

// OpenCV writes `%YAML:1.0`, which is not a YAML directive; as a comment it keeps the line numbers right.
Section load_opencv_yaml(const fs::path& file) {
  std::error_code ec;
  if (!fs::is_regular_file(file, ec))
    throw InputError(fmt::format("{}: no such calibration file; check the path", file.string()));
  if (fs::file_size(file, ec) > (1U << 20))
    throw InputError(fmt::format("{}: larger than 1 MiB, which no calibration file is", file.string()));
  std::ifstream in(file);
  std::stringstream buffer;
  buffer << in.rdbuf();
  std::string text = buffer.str();
  if (text.starts_with("%YAML:")) text[0] = '#';
  return Section::parse(text, file.string());
}

// A YAML text in single quotes, which takes any character but a line break.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : config::one_line(text)) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

std::string camera_text(const CameraIntrinsics& c) {
  return fmt::format(
      "  focal: [{}, {}]  # fx, fy [px]\n  centre: [{}, {}]\n"
      "  distortion: [{}, {}, {}, {}, {}]  # k1, k2, p1, p2, k3\n",
      c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3);
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

struct EurocCamera {
  CameraIntrinsics intrinsics;
  Eigen::Isometry3d body_from_sensor;
};

Eigen::Isometry3d isometry_from(const Section& section) {
  const auto d = section.numbers("data", 16, {-1000, 1000});
  Eigen::Matrix4d m = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(d.data());
  if ((m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-9)
    section.fail("data", "its last row is not 0 0 0 1, expected a rigid transform");
  const Eigen::Matrix3d r = m.topLeftCorner<3, 3>();
  if ((r * r.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-3 || r.determinant() < 0)
    section.fail("data", "its upper left 3x3 is not a rotation, expected a rigid transform");
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = Eigen::Quaterniond(r).normalized().toRotationMatrix();  // files round to 12 digits
  out.translation() = m.topRightCorner<3, 1>();
  return out;
}

EurocCamera read_euroc_camera(const fs::path& file) {
  const Section section = load_opencv_yaml(file);
  section.choice("camera_model", {"pinhole"});
  section.choice("distortion_model", {"radial-tangential"});
  EurocCamera camera{{}, isometry_from(section.section("T_BS"))};
  CameraIntrinsics& c = camera.intrinsics;
  const auto size = section.numbers("resolution", 2, {16, 16384, "px"});
  const auto k = section.numbers("intrinsics", 4, {0, 1e6, "px"});
  const auto d = section.numbers("distortion_coefficients", 4, {-100, 100});
  c.width = static_cast<int>(size[0]), c.height = static_cast<int>(size[1]);
  c.fx = k[0], c.fy = k[1], c.cx = k[2], c.cy = k[3];
  c.k1 = d[0], c.k2 = d[1], c.p1 = d[2], c.p2 = d[3];
  return camera;
}

}  // namespace

StereoRig rig_from(const Section& section) {
  StereoRig rig;
  rig.name = section.text("name");
  const auto size = section.numbers("size", 2, {16, 16384, "px"});
  rig.left = camera_from(section.section("left"), size);
  rig.right = camera_from(section.section("right"), size);
  rig.right_from_left = transform_from(section.section("right_from_left"));
  rig.nearest = section.number("nearest", {0.05, 100, "m"});
  rig.farthest = section.number("farthest", {0.05, 1000, "m"});
  rig.disparity_sigma = section.number_or("disparity_sigma", rig.disparity_sigma, {0.01, 10, "px"});
  require_usable_at(section, rig);
  return rig;
}

StereoRig read_rig(const fs::path& file) {
  const Section section = Section::load(file, "rig");
  StereoRig rig = rig_from(section);
  section.finish();
  return rig;
}

void write_rig(const StereoRig& rig, const fs::path& file) {
  require_usable(rig);
  std::ofstream out(file);
  out << rig_text(rig);
  if (!out.flush())
    throw InputError(
        fmt::format("{}: cannot be written, expected a path in a folder that is there", file.string()));
}

StereoRig read_euroc_rig(const fs::path& dir, const DepthLimits& limits) {
  const EurocCamera left = read_euroc_camera(dir / "cam0" / "sensor.yaml");
  const EurocCamera right = read_euroc_camera(dir / "cam1" / "sensor.yaml");
  StereoRig rig;
  rig.name = dir.string();
  rig.left = left.intrinsics;
  rig.right = right.intrinsics;
  rig.right_from_left = right.body_from_sensor.inverse() * left.body_from_sensor;
  rig.nearest = limits.nearest;
  rig.farthest = limits.farthest;
  require_usable(rig);
  return rig;
}

}  // namespace headway::vision
