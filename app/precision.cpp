#include "app/precision.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace headway::app {

namespace {

constexpr std::size_t kKept = 16;  // exposures whose view may still come
constexpr double kJump = 0.05;     // share of the depth that makes an edge
constexpr double kGross = 0.1;

double true_depth(const sim::Scene& scene, const vision::PinholeCamera& camera,
                  const Eigen::Isometry3d& map_from_view, int u, int v) {
  const Eigen::Vector3d ray = camera.point(u, v, 1);
  return scene.distance(map_from_view.translation(), map_from_view.linear() * ray) / ray.norm();
}

}  // namespace

void PrecisionCheck::expose(Time exposure, const sim::Scene& scene, const vision::PinholeCamera& camera,
                            const Eigen::Isometry3d& map_from_view) {
  Truth truth;
  truth.exposure = exposure;
  truth.width = camera.width;
  for (int v = kStride / 2; v < camera.height; v += kStride)
    for (int u = kStride / 2; u < camera.width; u += kStride) {
      const double z = true_depth(scene, camera, map_from_view, u, v);
      bool edge = false;
      for (const auto& [du, dv] :
           {std::array{-2, 0}, std::array{2, 0}, std::array{0, -2}, std::array{0, 2}}) {
        const double beside = true_depth(scene, camera, map_from_view, u + du, v + dv);
        edge |= !(std::abs(beside - z) < kJump * z);
      }
      truth.depth.push_back(static_cast<float>(z));
      truth.edge.push_back(edge);
    }
  waiting_.push_back(std::move(truth));
  if (waiting_.size() > kKept) waiting_.pop_front();
}

void PrecisionCheck::judge(Time exposure, const vision::RangeView& view) {
  const auto found =
      std::find_if(waiting_.begin(), waiting_.end(), [&](const Truth& t) { return t.exposure == exposure; });
  if (found == waiting_.end() || found->width != view.camera.width) return;
  std::size_t i = 0;
  for (int v = kStride / 2; v < view.camera.height; v += kStride)
    for (int u = kStride / 2; u < view.camera.width; u += kStride, ++i) {
      const double z = static_cast<double>(view.depth[view.index(u, v)]);
      const double truth = static_cast<double>(found->depth[i]);
      if (!std::isfinite(z) || !std::isfinite(truth) || z > view.far) continue;
      const double error = std::abs(z - truth);
      const double weight = view.weight.empty() ? 1 : static_cast<double>(view.weight[view.index(u, v)]);
      const bool within = error <= 3 * static_cast<double>(view.sigma_depth[view.index(u, v)]);
      ++result_.points;
      result_.weight += weight;
      if (within) {
        ++result_.within_3_sigma;
        result_.weight_within += weight;
      } else if (found->edge[i])
        ++result_.at_edges;
      if (error > kGross * truth) ++result_.gross;
    }
  waiting_.erase(waiting_.begin(), found + 1);
}

}  // namespace headway::app
