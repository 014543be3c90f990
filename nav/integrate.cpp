#include "nav/integrate.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "hal/error.h"
#include "nav/range_samples.h"
#include "nav/voxel_marks.h"

namespace headway::nav {
namespace {

constexpr int kEdge = VoxelMap::kBrickEdge;

/// Evidence added to a voxel; the first makes it known.
LogOdds updated(LogOdds value, int evidence) {
  const int sum = (value == log_odds::kUnseen ? 0 : value) + evidence;
  return static_cast<LogOdds>(std::clamp<int>(sum, log_odds::kLowest, log_odds::kHighest));
}

/// A voxel's coordinates in the camera's frame, linear in its integer coordinates.
struct Projection {
  Eigen::Vector3f dx, dy, dz;  ///< one voxel along x, y, z of the map [m]
  Eigen::Isometry3d camera_from_map;
  Eigen::Matrix3f extent;  ///< columns: |dx|, |dy|, |dz|

  Projection(const VoxelMap& map, const Eigen::Isometry3d& map_from_camera)
      : camera_from_map(map_from_camera.inverse()) {
    const Eigen::Matrix3f step = (camera_from_map.linear() * map.resolution()).cast<float>();
    dx = step.col(0);
    dy = step.col(1);
    dz = step.col(2);
    extent = step.cwiseAbs();
  }
};

/// The inclusive box of bricks that may lie in the view.
struct BrickBox {
  Eigen::Vector3i first, last;
};

BrickBox bricks_in_view(const VoxelMap& map, const RangeSamples& image,
                        const Eigen::Isometry3d& map_from_camera) {
  Eigen::Vector3d low = map_from_camera.translation(), high = low;
  const double z = static_cast<double>(image.farthest());
  for (const float u : {-0.5F, image.end_u()}) {
    for (const float v : {-0.5F, image.end_v()}) {
      const double x = static_cast<double>((u - image.cx()) / image.focal());
      const double y = static_cast<double>((v - image.cy()) / image.focal());
      const Eigen::Vector3d corner = map_from_camera * Eigen::Vector3d(x * z, y * z, z);
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const double brick = map.resolution() * kEdge;
  const Eigen::Array3d end = map.bricks().cast<double>();
  const auto brick_of = [&](const Eigen::Vector3d& p) -> Eigen::Array3i {
    return ((p - map.lowest()).array() / brick).floor().max(-1).min(end).cast<int>();
  };
  return {brick_of(low).max(0), brick_of(high).min(map.bricks().array() - 1)};
}

/// Where a brick lies to the view.
enum class Place { kOutside, kBehind, kEmpty, kMixed };

/// One brick's evidence.
struct Evidence {
  std::array<std::int8_t, VoxelMap::kBrickVoxels> of{};  ///< log-odds to add; 0: nothing known
};

/// Columns of a brick as bits y * 8 + x.
using ColumnBits = std::uint64_t;

}  // namespace

void IntegrationConfig::validate() const {
  const auto check = [](const char* name, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    throw InputError("integration: " + std::string(name) + ": " + std::to_string(value) + ", expected " +
                     std::to_string(lowest) + " to " + std::to_string(highest));
  };
  check("free_sigmas", free_sigmas, 0, 10);
  check("hit_sigmas", hit_sigmas, 0, 5);
  check("least_hit", least_hit, 0.05, 1);
  check("least_weight", least_weight, 0, 1);
  check("supporters", supporters, 0, 8);
  check("longest_hit", longest_hit, 0.5, 100);
  for (const BodyBox& box : own_body) {
    if (!(box.lowest.array() < box.highest.array()).all()) {
      throw InputError("integration: own_body: a box whose lowest corner does not lie below its highest");
    }
  }
}

struct Integrator::Scratch {
  RangeSamples image;
  VoxelMarks marks;
  Evidence evidence;

  void mark_points(const VoxelMap& map, const Eigen::Isometry3d& map_from_camera,
                   const IntegrationConfig& config);
  Place place(const VoxelMap& map, const Projection& projection, const Eigen::Vector3i& brick, float near,
              bool marked) const;
  void see_voxels(const Eigen::Vector3f& first, const Projection& projection, float near);
  void add_marks(const VoxelMarks::Brick& marks, std::int8_t least_hit);
  void apply(VoxelMap& map, std::size_t brick, Time stamp, IntegrationStats& stats) const;
};

// Every sample marks its own voxel. At the edges of surfaces the voxels along the uncertain stretch of its
// ray are kept from being emptied by the rays that pass beside it.
void Integrator::Scratch::mark_points(const VoxelMap& map, const Eigen::Isometry3d& map_from_camera,
                                      const IntegrationConfig& config) {
  marks.reset(map);
  const double per_metre = 1 / map.resolution();
  const Eigen::Matrix3f turn = (map_from_camera.linear() * per_metre).cast<float>();
  const Eigen::Vector3f origin = ((map_from_camera.translation() - map.lowest()) * per_metre).cast<float>();
  const auto step = static_cast<float>(map.resolution() / 2);
  constexpr float kMostSteps = 1000;  // a sigma beyond all measure must not stall the view
  const auto free_sigmas = static_cast<float>(config.free_sigmas),
             hit_sigmas = static_cast<float>(config.hit_sigmas);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const float w = image.inverse_depth(x, y);
      if (w <= 0) continue;
      const Eigen::Vector3f ray =
          turn * Eigen::Vector3f((static_cast<float>(x) - image.cx()) / image.focal(),
                                 (static_cast<float>(y) - image.cy()) / image.focal(), 1);
      const float z = 1 / w;
      if (z > image.farthest()) continue;
      marks.mark(origin + z * ray, VoxelMarks::kHit);
      if (!image.at_edge(x, y)) continue;
      const float sigma = image.inverse_sigma(x, y) * z * z;
      const float begin = std::max(0.0F, z - free_sigmas * sigma);
      const float end = std::min(z + hit_sigmas * sigma, image.farthest());
      const int steps = static_cast<int>(std::min((end - begin) / step, kMostSteps));
      for (int k = 0; k <= steps; ++k) {
        marks.mark(origin + (begin + static_cast<float>(k) * step) * ray, VoxelMarks::kKeep);
      }
    }
  }
}

// Decides on whole bricks by bounds that hold for each of their voxels.
Place Integrator::Scratch::place(const VoxelMap& map, const Projection& projection,
                                 const Eigen::Vector3i& brick, float near, bool marked) const {
  const Eigen::Vector3d centre =
      map.lowest() + ((brick * kEdge).cast<double>().array() + kEdge / 2.0).matrix() * map.resolution();
  const Eigen::Vector3f c = (projection.camera_from_map * centre).cast<float>();
  const Eigen::Vector3f reach = projection.extent.rowwise().sum() * kEdge / 2.0F;
  const float z0 = c.z() - reach.z(), z1 = c.z() + reach.z();
  if (z1 < near) return Place::kOutside;
  if (z0 > image.farthest()) return Place::kBehind;
  if (z0 < near) return Place::kMixed;
  // The extremes of X/Z lie at the corners of the box around the brick.
  const auto ends = [&](float x, float r, float offset) {
    const float low = x - r, high = x + r;
    return std::pair(image.focal() * low / (low < 0 ? z0 : z1) + offset,
                     image.focal() * high / (high < 0 ? z1 : z0) + offset);
  };
  const auto [u0, u1] = ends(c.x(), reach.x(), image.cx());
  const auto [v0, v1] = ends(c.y(), reach.y(), image.cy());
  if (u1 < -0.5F || v1 < -0.5F || u0 >= image.end_u() || v0 >= image.end_v()) return Place::kOutside;
  const auto cell = [](float u, int size) {
    return std::clamp(static_cast<int>(std::lround(u)), 0, size - 1);
  };
  const DepthBounds bounds = image.bounds(cell(u0, image.width()), cell(v0, image.height()),
                                          cell(u1, image.width()), cell(v1, image.height()));
  if (z0 > bounds.back) return Place::kBehind;
  const bool whole = u0 >= -0.5F && v0 >= -0.5F && u1 < image.end_u() && v1 < image.end_v();
  return whole && !marked && z1 <= image.farthest() && z1 < bounds.free ? Place::kEmpty : Place::kMixed;
}

// Projects each voxel's centre into the image and compares it with the plane seen there. A voxel that may
// reach over the image's border says nothing: what stands in its other part is not seen.
void Integrator::Scratch::see_voxels(const Eigen::Vector3f& first, const Projection& projection, float near) {
  const float focal = image.focal(), cx = image.cx(), cy = image.cy();
  const float end_u = image.end_u(), end_v = image.end_v(), far = image.farthest();
  const float half_edge = projection.dx.norm() / 2;
  std::array<float, kEdge> px, py, pz, pu, pv, inset;
  for (int row = 0; row < kEdge * kEdge; ++row) {
    const Eigen::Vector3f start =
        first + static_cast<float>(row & 7) * projection.dy + static_cast<float>(row >> 3) * projection.dz;
    for (std::size_t i = 0; i < kEdge; ++i) {
      const auto f = static_cast<float>(i);
      px[i] = start.x() + f * projection.dx.x();
      py[i] = start.y() + f * projection.dx.y();
      pz[i] = start.z() + f * projection.dx.z();
      const float scale = focal / pz[i];
      pu[i] = px[i] * scale + cx;
      pv[i] = py[i] * scale + cy;
      inset[i] = half_edge * scale - 0.5F;
    }
    for (std::size_t i = 0; i < kEdge; ++i) {
      std::int8_t& e =
          evidence.of[static_cast<std::size_t>(in_brick(static_cast<int>(i), row & 7, row >> 3))];
      e = 0;
      const bool in_view = pz[i] >= near && pz[i] <= far && pu[i] >= inset[i] && pv[i] >= inset[i] &&
                           pu[i] < end_u - inset[i] - 0.5F && pv[i] < end_v - inset[i] - 0.5F;
      if (!in_view) continue;
      const RangeSample& s = image.at(static_cast<int>(pu[i] + 0.5F), static_cast<int>(pv[i] + 0.5F));
      const float r = s.nx * px[i] + s.ny * py[i] + s.nz * pz[i];
      if (r < s.free) {
        e = log_odds::kMiss;
      } else if (std::abs(r - 1) <= s.half) {
        e = static_cast<std::int8_t>(s.hit);
      }
    }
  }
}

void Integrator::Scratch::add_marks(const VoxelMarks::Brick& brick, std::int8_t least_hit) {
  for (std::size_t i = 0; i < brick.size(); ++i) {
    if (brick[i] == VoxelMarks::kHit) evidence.of[i] = std::max(evidence.of[i], least_hit);
    if (brick[i] == VoxelMarks::kKeep) evidence.of[i] = std::max<std::int8_t>(evidence.of[i], 0);
  }
}

void Integrator::Scratch::apply(VoxelMap& map, std::size_t brick, Time stamp, IntegrationStats& stats) const {
  const Eigen::Vector3i first = kEdge * map.brick_at(brick);
  const auto values = map.edit(brick);
  const double obstacle_height = map.config().obstacle_height;
  bool changed = false;
  ColumnBits seen = 0;
  for (int z = 0; z < kEdge; ++z) {
    const int layer = first.z() + z;
    const bool foot = layer >= map.foot_begin() && layer < map.foot_end();
    const bool obstacle = layer >= map.foot_end() && map.centre({0, 0, layer}).z() <= obstacle_height;
    for (int k = 0; k < kEdge * kEdge; ++k) {
      const auto i = static_cast<std::size_t>(in_brick(k & 7, k >> 3, z));
      const int e = evidence.of[i];
      if (e == 0) continue;
      (e > 0 ? stats.hits : stats.misses) += 1;
      if (foot || (obstacle && e > 0)) seen |= ColumnBits{1} << k;
      const LogOdds value = updated(values[i], e);
      changed |= value != values[i];
      values[i] = value;
    }
  }
  for (; seen != 0; seen &= seen - 1) {
    const int k = std::countr_zero(seen);
    map.see_floor(first.x() + (k & 7), first.y() + (k >> 3), stamp);
  }
  if (!changed) return;
  const std::size_t unseen = map.summary(brick).unseen;
  map.settle(brick, stamp);
  stats.first_seen += unseen - map.summary(brick).unseen;
  ++stats.bricks_changed;
}

Integrator::Integrator(const IntegrationConfig& config)
    : config_(config), scratch_(std::make_unique<Scratch>()) {
  config_.validate();
}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;
Integrator& Integrator::operator=(Integrator&&) noexcept = default;

IntegrationStats Integrator::integrate(VoxelMap& map, const vision::RangeView& view,
                                       const Eigen::Isometry3d& map_from_camera, Time stamp,
                                       const Eigen::Isometry3d& map_from_body) {
  const auto pixels =
      static_cast<std::size_t>(view.camera.width) * static_cast<std::size_t>(view.camera.height);
  if (view.depth.size() != pixels || view.sigma_depth.size() != pixels ||
      !map_from_camera.matrix().allFinite()) {
    throw Error(
        "a range view without one depth and sigma per pixel, or without a finite pose, cannot be mapped");
  }
  Scratch& s = *scratch_;
  s.image.take(view, config_, map.resolution(), map_from_camera.linear(),
               map_from_body.inverse() * map_from_camera);
  IntegrationStats stats;
  stats.samples = s.image.used();
  stats.rejected = s.image.rejected();
  if (stats.samples == 0) return stats;

  s.mark_points(map, map_from_camera, config_);
  const Projection projection(map, map_from_camera);
  const auto near = static_cast<float>(view.near);
  const auto least_hit = static_cast<std::int8_t>(std::lround(config_.least_hit * log_odds::kHit));
  const BrickBox box = bricks_in_view(map, s.image, map_from_camera);
  for (int z = box.first.z(); z <= box.last.z(); ++z) {
    for (int y = box.first.y(); y <= box.last.y(); ++y) {
      for (int x = box.first.x(); x <= box.last.x(); ++x) {
        const Eigen::Vector3i at(x, y, z);
        const std::size_t brick = map.brick_index(at);
        const VoxelMarks::Brick* marks = s.marks.at(brick);
        const Place place = s.place(map, projection, at, near, marks != nullptr);
        if (place == Place::kEmpty) {
          s.evidence.of.fill(log_odds::kMiss);
        } else if (place == Place::kMixed) {
          s.see_voxels((projection.camera_from_map * map.centre(kEdge * at)).cast<float>(), projection, near);
        } else if (marks != nullptr) {
          s.evidence.of.fill(0);
        } else {
          continue;
        }
        if (marks != nullptr) s.add_marks(*marks, least_hit);
        s.apply(map, brick, stamp, stats);
      }
    }
  }
  return stats;
}

IntegrationStats integrate(VoxelMap& map, const vision::RangeView& view,
                           const Eigen::Isometry3d& map_from_camera, Time stamp,
                           const IntegrationConfig& config) {
  return Integrator(config).integrate(map, view, map_from_camera, stamp);
}

}  // namespace headway::nav
