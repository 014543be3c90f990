#include "app/level.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "hal/angle.h"

namespace headway::app {

namespace {

constexpr int kStride = 3;          // every third pixel of a patch is looked at
constexpr double kRoughest = 0.02;  // share of the depth by which a patch may leave its plane, with its noise
constexpr double kMostMissing = 0.2;  // share of a patch's pixels without a depth
constexpr std::size_t kFewest = 50;   // surfels that say something

/// The plane n . p = 1 through a patch, in the camera's frame: planes are linear in inverse depth, and its
/// noise is the same everywhere. Nothing where the patch is no plane.
std::optional<Eigen::Vector3d> fit_plane(const vision::RangeView& view, int u0, int v0, int reach) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0, noise = 0;
  int found = 0, asked = 0;
  for (int v = v0 - reach; v <= v0 + reach; v += kStride) {
    for (int u = u0 - reach; u <= u0 + reach; u += kStride) {
      ++asked;
      const auto z = static_cast<double>(view.depth[view.index(u, v)]);
      if (!(z >= view.near && z <= view.far)) continue;
      const Eigen::Vector3d ray = view.camera.point(u, v, 1);
      sum += ray * ray.transpose();
      right += ray / z;
      squares += 1 / (z * z);
      noise += static_cast<double>(view.sigma_depth[view.index(u, v)]) / z;
      ++found;
    }
  }
  if (found < (1 - kMostMissing) * asked) return std::nullopt;
  const Eigen::Vector3d n = sum.ldlt().solve(right);
  const double left_over = std::max(0.0, squares - n.dot(right));  // of least squares
  const double rms = std::sqrt(left_over / squares);               // as a share of the depth
  if (!n.allFinite() || rms > kRoughest + 2 * noise / found) return std::nullopt;
  return n;
}

/// How well a direction suits the surfels: each counts that lies within a few degrees of level or of upright.
double agreement(const std::vector<Surfel>& surfels, const Eigen::Vector3d& up) {
  constexpr double kWidth = 4 * kDegree;
  double sum = 0;
  for (const Surfel& s : surfels) {
    const double cosine = std::clamp(s.normal.dot(up), -1.0, 1.0);
    const double off_level = std::acos(std::abs(cosine)), off_upright = std::asin(std::abs(cosine));
    const double off = std::min(off_level, off_upright) / kWidth;
    if (off < 3) sum += std::exp(-off * off);
  }
  return sum;
}

/// Directions around `middle`, up to `widest` off it, `step` apart [rad]; the best of them.
Eigen::Vector3d best_around(const std::vector<Surfel>& surfels, const Eigen::Vector3d& middle, double widest,
                            double step) {
  const Eigen::Vector3d side = middle.unitOrthogonal(), other = middle.cross(side);
  Eigen::Vector3d best = middle;
  double most = agreement(surfels, middle);
  for (double off = step; off <= widest + 1e-9; off += step) {
    const int around = std::max(6, static_cast<int>(std::ceil(2 * std::numbers::pi * std::sin(off) / step)));
    for (int i = 0; i < around; ++i) {
      const double a = 2 * std::numbers::pi * i / around;
      const Eigen::Vector3d up =
          std::cos(off) * middle + std::sin(off) * (std::cos(a) * side + std::sin(a) * other);
      if (const double score = agreement(surfels, up); score > most) most = score, best = up;
    }
  }
  return best;
}

std::vector<Surfel> thinned(const std::vector<Surfel>& surfels, std::size_t wanted) {
  std::vector<Surfel> few;
  const std::size_t every = std::max<std::size_t>(1, surfels.size() / wanted);
  for (std::size_t i = 0; i < surfels.size(); i += every) few.push_back(surfels[i]);
  return few;
}

}  // namespace

void add_surfels(const vision::RangeView& view, const Eigen::Isometry3d& world_from_camera,
                 std::size_t wanted, std::vector<Surfel>& into) {
  const vision::PinholeCamera& c = view.camera;
  const int reach = std::max(4, c.width / 50);
  const double area = static_cast<double>(c.width) * c.height;
  const int step =
      std::max(2, static_cast<int>(std::sqrt(area / static_cast<double>(std::max<std::size_t>(wanted, 1)))));
  for (int v = reach; v + reach < c.height; v += step) {
    for (int u = reach; u + reach < c.width; u += step) {
      const auto n = fit_plane(view, u, v, reach);
      if (!n) continue;
      const Eigen::Vector3d ray = c.point(u, v, 1);
      const double z = 1 / n->dot(ray);
      if (!(z >= view.near && z <= view.far)) continue;
      into.push_back({world_from_camera * (z * ray), -(world_from_camera.linear() * n->normalized())});
    }
  }
}

Eigen::Vector3d estimate_up(const std::vector<Surfel>& surfels, const Eigen::Vector3d& guess) {
  const std::vector<Surfel> few = thinned(surfels, 3000);
  if (few.size() < kFewest) return guess.normalized();
  const Eigen::Vector3d rough = best_around(few, guess.normalized(), 50 * kDegree, 2.5 * kDegree);
  return best_around(few, rough, 2.5 * kDegree, 0.25 * kDegree);
}

FloorHeight estimate_floor(const std::vector<Surfel>& surfels, const Eigen::Vector3d& up) {
  constexpr double kBin = 0.04, kLarge = 0.25;
  std::vector<double> all, level;
  for (const Surfel& s : surfels) {
    all.push_back(s.point.dot(up));
    if (s.normal.dot(up) > std::cos(15 * kDegree)) level.push_back(all.back());
  }
  if (all.empty()) return {0, "nothing was seen; the poses' own zero is taken"};
  std::sort(all.begin(), all.end());
  const double lowest = all[all.size() / 100];
  if (level.size() < kFewest)
    return {lowest, "no level surface was seen; the lowest percent of the points is taken"};
  // Heights within two bins of each start: the first such window that is large, and the median in it.
  std::sort(level.begin(), level.end());
  const auto count = [&](double from) {
    return std::lower_bound(level.begin(), level.end(), from + 2 * kBin) -
           std::lower_bound(level.begin(), level.end(), from);
  };
  std::ptrdiff_t most = 0;
  for (double from = level.front(); from <= level.back(); from += kBin / 2)
    most = std::max(most, count(from));
  const auto large = static_cast<std::ptrdiff_t>(std::ceil(kLarge * static_cast<double>(most)));
  double from = level.front();
  while (count(from) < large) from += kBin / 2;
  while (count(from + kBin / 2) > count(from)) from += kBin / 2;
  const auto first = std::lower_bound(level.begin(), level.end(), from);
  const double height = *(first + count(from) / 2);
  return {height, fmt::format("lowest large level surface facing up, of {} pieces", count(from))};
}

Eigen::Isometry3d map_from_world(const Eigen::Vector3d& up, double floor_height,
                                 const Eigen::Isometry3d& world_from_camera) {
  const Eigen::Vector3d z = up.normalized();
  const Eigen::Vector3d ahead = world_from_camera.linear().col(2);
  Eigen::Vector3d x = ahead - ahead.dot(z) * z;
  // A camera that looks straight down has its image's top ahead.
  if (x.norm() < 1e-3) x = -world_from_camera.linear().col(1) + world_from_camera.linear().col(1).dot(z) * z;
  x.normalize();
  Eigen::Isometry3d map = Eigen::Isometry3d::Identity();
  map.linear() << x.transpose(), z.cross(x).transpose(), z.transpose();
  const Eigen::Vector3d eye = world_from_camera.translation();
  const Eigen::Vector3d foot = eye + (floor_height - eye.dot(z)) * z;
  map.translation() = -(map.linear() * foot);
  return map;
}

}  // namespace headway::app
