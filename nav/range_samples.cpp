#include "nav/range_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headway::nav {
namespace {

/// The slope of inverse depth per sample between two neighbours, each `apart` samples away: central on one
/// surface, to one side at an edge, level where neither side belongs to the surface.
float slope(float before, float w, float after, float tolerance, float apart) {
  const float down = w - before, up = after - w;
  if (before > 0 && after > 0 && std::abs(up - down) <= 2 * tolerance) return (up + down) / (2 * apart);
  const bool use_down = before > 0 && (after <= 0 || std::abs(down) <= std::abs(up));
  const float one_sided = use_down ? down : up;
  const bool on_surface = (use_down ? before : after) > 0 && std::abs(one_sided) <= apart * tolerance;
  return on_surface ? one_sided / apart : 0;
}

}  // namespace

void RangeSamples::take(const vision::RangeView& view, const IntegrationConfig& config, double resolution,
                        const Eigen::Matrix3d& map_from_camera, const Eigen::Isometry3d& body_from_camera) {
  rejected_ = used_ = 0;
  reduce(view, static_cast<float>(config.least_weight), resolution);
  if (!config.own_body.empty()) forget_own_body(config.own_body, body_from_camera);
  rejected_ += smooth(rough_, config.supporters, static_cast<float>(resolution), image_);

  const std::size_t count = static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height);
  samples_.assign(count, {});
  edge_.assign(count, 0);
  tiles_x_ = (image_.width + kTile - 1) / kTile;
  const int tiles_y = (image_.height + kTile - 1) / kTile;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  tiles_.assign(static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y), {kInfinity, 0});
  farthest_ = 0;
  const Eigen::Matrix3f rotation = map_from_camera.cast<float>();
  for (int y = 0; y < image_.height; ++y) {
    for (int x = 0; x < image_.width; ++x) describe(x, y, config, static_cast<float>(resolution), rotation);
  }
  farthest_ = std::min(farthest_, static_cast<float>(view.far));
}

void RangeSamples::reduce(const vision::RangeView& view, float least_weight, double resolution) {
  // A voxel at the far end should still be as wide as a sample.
  const double pixels_per_voxel = view.camera.focal * resolution / view.far;
  const int reduction = pixels_per_voxel >= 4 ? 4 : pixels_per_voxel >= 2 ? 2 : 1;
  const auto f = static_cast<float>(resolution);
  if (reduction == 1) {
    invert(view, least_weight, rough_);
  } else {
    invert(view, least_weight, full_);
    halve(full_, f, reduction == 2 ? rough_ : half_);
    if (reduction == 4) halve(half_, f, rough_);
  }
  const double first_centre = (reduction - 1) / 2.0;
  focal_ = static_cast<float>(view.camera.focal / reduction);
  cx_ = static_cast<float>((view.camera.cx - first_centre) / reduction);
  cy_ = static_cast<float>((view.camera.cy - first_centre) / reduction);
  end_u_ = static_cast<float>(view.camera.width) / static_cast<float>(reduction) - 0.5F;
  end_v_ = static_cast<float>(view.camera.height) / static_cast<float>(reduction) - 0.5F;
}

void RangeSamples::forget_own_body(const std::vector<BodyBox>& boxes,
                                   const Eigen::Isometry3d& body_from_camera) {
  const Eigen::Isometry3f body = body_from_camera.cast<float>();
  for (int y = 0; y < rough_.height; ++y) {
    for (int x = 0; x < rough_.width; ++x) {
      float& w = rough_.w[rough_.index(x, y)];
      if (w <= 0) continue;
      const Eigen::Vector3f ray((static_cast<float>(x) - cx_) / focal_,
                                (static_cast<float>(y) - cy_) / focal_, 1);
      const Eigen::Vector3d point = (body * Eigen::Vector3f(ray / w)).cast<double>();
      const bool own = std::any_of(boxes.begin(), boxes.end(), [&](const BodyBox& box) {
        return (point.array() >= box.lowest.array()).all() && (point.array() <= box.highest.array()).all();
      });
      if (!own) continue;
      w = 0;
      ++rejected_;
    }
  }
}

void RangeSamples::describe(int x, int y, const IntegrationConfig& config, float resolution,
                            const Eigen::Matrix3f& map_from_camera) {
  const std::size_t i = image_.index(x, y);
  const auto down = static_cast<std::size_t>(image_.stride());
  const float* image = image_.w.data();
  const float w = image[i], sigma = image_.sigma[i];
  RangeSample& s = samples_[sample(x, y)];
  if (w <= 0) return add_to_tile(x, y, s, w);
  ++used_;
  const float tolerance = same_surface(w, sigma, resolution);

  // The plane: its normal is the gradient of w over (x, y, 1). Taps two apart halve the noise where that is
  // finer than a voxel.
  float du = slope(image[i - 2], w, image[i + 2], tolerance, 2);
  float dv = slope(image[i - 2 * down], w, image[i + 2 * down], tolerance, 2);
  // So steep that the plane would run away within the sample: no surface that a camera measures.
  if (std::abs(du) + std::abs(dv) > w / 2) du = dv = 0;
  const Eigen::Vector3f ray((static_cast<float>(x) - cx_) / focal_, (static_cast<float>(y) - cy_) / focal_,
                            1);
  Eigen::Vector3f n(du * focal_, dv * focal_, 0);
  n.z() = w - n.x() * ray.x() - n.y() * ray.y();

  // Half the depth of a voxel that the plane just touches, as a share of Z: |Q - P| along the ray over Z is
  // |n.(Q - P)|, at most |n|_1 times half an edge in the map's axes.
  const float half_edge = resolution / 2;
  const float half_voxel = std::min(half_edge * (map_from_camera * n).lpNorm<1>(),
                                    static_cast<float>(config.longest_hit) * resolution * w);
  const float relative_sigma = sigma / w;
  const float spread = static_cast<float>(config.hit_sigmas) * relative_sigma;
  s.nx = n.x();
  s.ny = n.y();
  s.nz = n.z();
  s.half = half_voxel + spread;
  s.free = std::max(0.0F, 1 - half_voxel - static_cast<float>(config.free_sigmas) * relative_sigma);
  s.hit = std::max(1, static_cast<int>(std::lround(log_odds::kHit * half_voxel / s.half)));

  // Beside a nearer surface only what lies before that one too is surely empty.
  float nearest = w, farthest = w;
  for (const std::size_t k :
       {i - down - 1, i - down, i - down + 1, i - 1, i + 1, i + down - 1, i + down, i + down + 1}) {
    nearest = std::max(nearest, image[k]);
    if (image[k] > 0) farthest = std::min(farthest, image[k]);
  }
  const float step = tolerance + std::abs(du) + std::abs(dv);
  if (nearest - w > step) s.free *= w / nearest;
  edge_[sample(x, y)] = nearest - w > step || w - farthest > step;
  add_to_tile(x, y, s, w);
}

void RangeSamples::add_to_tile(int x, int y, const RangeSample& s, float w) {
  DepthBounds& t = tiles_[tile(x / kTile, y / kTile)];
  if (w <= 0) {
    t.free = 0;
    return;
  }
  // A voxel's ray may lie half a sample off the sample's own.
  const float lean = (std::abs(s.nx) + std::abs(s.ny)) / (2 * focal_);
  t.free = std::min(t.free, s.free / (w + lean));
  const float back = (1 + s.half) / (w - lean);
  t.back = std::max(t.back, back);
  farthest_ = std::max(farthest_, back);
}

DepthBounds RangeSamples::bounds(int x0, int y0, int x1, int y1) const {
  DepthBounds b{std::numeric_limits<float>::infinity(), 0};
  for (int y = y0 / kTile; y <= y1 / kTile; ++y) {
    for (int x = x0 / kTile; x <= x1 / kTile; ++x) {
      const DepthBounds& t = tiles_[tile(x, y)];
      b.free = std::min(b.free, t.free);
      b.back = std::max(b.back, t.back);
    }
  }
  return b;
}

}  // namespace headway::nav
