#include "vision/calibration_file.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "config/write_fault.h"
#include "config/yaml_limits.h"

namespace headway::vision {

namespace fs = std::filesystem;
using config::Section;

namespace {
constexpr double kLargest = 1e6;
}

Section load_calibration(const fs::path& file) {
  const std::string name = config::one_line(file.string());
  std::error_code ec;
  if (!fs::is_regular_file(file, ec))
    throw InputError(fmt::format("{}: no such calibration file; check the path", name));
  if (fs::file_size(file, ec) > config::YamlLimits{}.bytes)
    throw InputError(fmt::format("{}: larger than 1 MiB, which no calibration file is", name));
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(fmt::format("{}: cannot be read; check its permissions", name));
  std::stringstream buffer;
  buffer << in.rdbuf();
  std::string text = buffer.str();
  if (text.starts_with("%YAML:")) text[0] = '#';  // a comment keeps the line numbers right
  return Section::parse(text, file.string());
}

void write_text(const std::string& text, const fs::path& file) {
  errno = 0;
  std::ofstream out(file, std::ios::binary);
  if (!out) config::fail_to_write(file, "cannot be written", errno);
  if (!(out << text).flush()) config::fail_to_write(file, "cannot be written completely", errno);
}

std::vector<double> matrix_of(const Section& section, std::string_view key, int rows, int columns) {
  const Section m = section.section(key);
  const double r = rows, c = columns;
  m.integer("rows", {r, r});
  m.integer("cols", {c, c});
  return m.numbers("data", static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns),
                   {-kLargest, kLargest});
}

std::vector<double> vector_of(const Section& section, std::string_view key, std::size_t most) {
  const Section v = section.section(key);
  auto data = v.numbers_between("data", 0, most, {-kLargest, kLargest});
  const int rows = v.integer("rows", {0, 16}), columns = v.integer("cols", {0, 16});
  if (std::min(rows, columns) > 1 ||
      static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) != data.size())
    v.fail("data", fmt::format("holds {} numbers for {} x {}, expected one row or one column", data.size(),
                               rows, columns));
  return data;
}

void set_size(CameraIntrinsics& camera, const Section& section, std::string_view key) {
  const auto size = section.numbers(key, 2, {16, 16384, "px"});
  for (const double extent : size)
    if (extent != std::floor(extent)) section.fail(key, fmt::format("{}, expected whole numbers", extent));
  camera.width = static_cast<int>(size[0]), camera.height = static_cast<int>(size[1]);
}

Eigen::Matrix3d rotation_from(const std::vector<double>& m, const Section& section, std::string_view key) {
  Eigen::Matrix3d r = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.data());
  if (!((r * r.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3) || r.determinant() < 0)
    section.fail(key, "is not a rotation, expected rows of length 1, at right angles, right-handed");
  if (r == Eigen::Matrix3d::Identity()) return r;
  return Eigen::Quaterniond(r).normalized().toRotationMatrix();
}

Eigen::Isometry3d transform_from(const std::vector<double>& m, const Section& section, std::string_view key) {
  if ((Eigen::Map<const Eigen::RowVector4d>(&m[12]) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-9)
    section.fail(key, "its last row is not 0 0 0 1, expected a rigid transform");
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = rotation_from({m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}, section, key);
  out.translation() << m[3], m[7], m[11];
  return out;
}

void set_lens(CameraIntrinsics& c, LensModel lens, const std::vector<double>& k, const Section& section,
              std::string_view key) {
  const std::size_t n = k.size();
  c.lens = lens;
  if (lens == LensModel::kEquidistant) {
    if (n != 4) section.fail(key, fmt::format("{} coefficients, expected 4 (k1 k2 k3 k4)", n));
    c.k1 = k[0], c.k2 = k[1], c.k3 = k[2], c.k4 = k[3];
    return;
  }
  if (lens == LensModel::kRational && n != 8)
    section.fail(key, fmt::format("{} coefficients, expected 8 (k1 k2 p1 p2 k3 k4 k5 k6)", n));
  if (lens == LensModel::kRadialTangential && n != 0 && n != 4 && n != 5)
    section.fail(key, fmt::format("{} coefficients, expected 4 or 5 (k1 k2 p1 p2, k3)", n));
  const auto at = [&](std::size_t i) { return i < n ? k[i] : 0.0; };
  c.k1 = at(0), c.k2 = at(1), c.p1 = at(2), c.p2 = at(3), c.k3 = at(4);
  c.k4 = at(5), c.k5 = at(6), c.k6 = at(7);
}

std::vector<double> coefficients_of(const CameraIntrinsics& c) {
  switch (c.lens) {
    case LensModel::kRadialTangential:
      break;
    case LensModel::kRational:
      return {c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6};
    case LensModel::kEquidistant:
      return {c.k1, c.k2, c.k3, c.k4};
  }
  return {c.k1, c.k2, c.p1, c.p2, c.k3};
}

void require_usable_at(const RigPlaces& places, const StereoRig& rig) {
  const auto fault = fault_of(rig);
  if (!fault) return;
  const std::string& key = fault->key;
  const Section& camera = key.starts_with("left.") ? places.left : places.right;
  if (key == "size") camera.fail(places.size, fault->what);
  if (key.ends_with(".focal")) camera.fail(places.focal, fault->what);
  if (key.ends_with(".centre")) camera.fail(places.centre, fault->what);
  if (key.ends_with(".distortion")) camera.fail(places.distortion, fault->what);
  if (key == "right_from_left") places.pose.fail(places.transform, fault->what);
  places.pose.fail(key, fault->what);
}

}  // namespace headway::vision
