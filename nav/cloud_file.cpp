#include "nav/cloud_file.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ostream>

#include "nav/little_endian.h"
#include "nav/whole_file.h"

namespace headway::nav {
namespace {

using Colour = std::array<std::uint8_t, 3>;

/// Blue (0) over green to red (1).
Colour ramp(double t) {
  const auto channel = [t](double middle) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(1.5 - 4 * std::abs(t - middle), 0.0, 1.0)));
  };
  return {channel(0.75), channel(0.5), channel(0.25)};
}

/// The point's resolution: sqrt of the covariance's largest eigenvalue [m].
double resolution(const CloudPoint& p) {
  Eigen::Matrix3d sigma;
  sigma << p.xx, p.xy, p.xz, p.xy, p.yy, p.yz, p.xz, p.yz, p.zz;
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sigma, Eigen::EigenvaluesOnly)
                                     .eigenvalues()
                                     .maxCoeff()));
}

void put_header(std::ostream& out, std::size_t count) {
  out << "ply\nformat binary_little_endian 1.0\ncomment map frame, metres; cov_* [m^2]; colour: largest "
         "standard "
         "deviation\nelement vertex "
      << count << '\n';
  for (const char* name : {"x", "y", "z"}) out << "property float " << name << '\n';
  for (const char* name : {"red", "green", "blue"}) out << "property uchar " << name << '\n';
  for (const char* name : {"xx", "xy", "xz", "yy", "yz", "zz"}) out << "property float cov_" << name << '\n';
  out << "end_header\n";
}

}  // namespace

void CloudFile::add(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera) {
  const Eigen::Matrix3d r = map_from_camera.linear();
  const int step = std::max(config_.every, 1);
  for (int v = 0; v < view.camera.height; v += step) {
    for (int u = 0; u < view.camera.width; u += step) {
      const double z = static_cast<double>(view.depth[view.index(u, v)]);
      if (!(z >= view.near && z <= view.far)) continue;
      const Eigen::Vector3d p = map_from_camera * view.camera.point(u, v, z);
      const Eigen::Matrix3f s = (r * view.covariance(u, v) * r.transpose()).cast<float>();
      points_.push_back({p.cast<float>(), s(0, 0), s(0, 1), s(0, 2), s(1, 1), s(1, 2), s(2, 2)});
    }
  }
}

void CloudFile::write(const std::filesystem::path& file) const {
  write_whole(file, [&](std::ostream& out) {
    put_header(out, points_.size());
    const double decades = std::log(config_.blurred / config_.sharp);
    for (const CloudPoint& p : points_) {
      for (const float c : {p.position.x(), p.position.y(), p.position.z()}) out << little_endian(c).text();
      const double t = std::log(std::max(resolution(p), 1e-9) / config_.sharp) / decades;
      for (const std::uint8_t c : ramp(std::clamp(t, 0.0, 1.0))) out.put(static_cast<char>(c));
      for (const float c : {p.xx, p.xy, p.xz, p.yy, p.yz, p.zz}) out << little_endian(c).text();
    }
  });
}

}  // namespace headway::nav
