#include "nav/integrate.h"

#include <cmath>
#include <string>

#include "hal/error.h"
#include "nav/brick_update.h"
#include "nav/range_samples.h"
#include "nav/voxel_marks.h"

namespace headway::nav {
namespace {

constexpr LogOdds kSureHit = log_odds::kHit - 1;  // sigma is small beside half a voxel

}  // namespace

void IntegrationConfig::validate() const {
  const auto check = [](const char* name, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    throw InputError("integration: " + std::string(name) + ": " + std::to_string(value) + ", expected " +
                     std::to_string(lowest) + " to " + std::to_string(highest));
  };
  check("free_sigmas", free_sigmas, 0, 10);
  check("least_hit_sigmas", least_hit_sigmas, 0, 5);
  check("hit_errors", hit_errors, 0, 5);
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
  RangeSamples samples;
  VoxelMarks marks;
};

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
  const double per_metre = 1 / map.resolution();
  const MarkFrame frame{(map_from_camera.linear() * per_metre).cast<float>(),
                        ((map_from_camera.translation() - map.lowest()) * per_metre).cast<float>(),
                        map.bricks()};
  s.marks.reset(map.brick_count());
  const RowsRead rows = map.views() % 2 == 0 ? RowsRead::kOuter : RowsRead::kInner;
  map.count_view();
  s.samples.take(view, config_, {map.resolution(), rows}, map_from_camera.linear(),
                 map_from_body.inverse() * map_from_camera, frame, s.marks);
  IntegrationStats stats;
  stats.samples = s.samples.used();
  stats.rejected = s.samples.rejected();
  if (stats.samples == 0) return stats;
  const SampleClasses classes(config_.free_sigmas, s.samples.hit_sigmas());
  const auto least_hit = static_cast<LogOdds>(std::lround(config_.least_hit * log_odds::kHit));
  const LogOdds turning_hit = view.weight.empty() ? least_hit : kSureHit;
  const auto least_before_hit = static_cast<LogOdds>(log_odds::kOccupied - turning_hit);
  update_bricks({s.samples, classes, s.marks, least_hit, least_before_hit, map_from_camera}, stamp, map,
                stats);
  return stats;
}

IntegrationStats integrate(VoxelMap& map, const vision::RangeView& view,
                           const Eigen::Isometry3d& map_from_camera, Time stamp,
                           const IntegrationConfig& config) {
  return Integrator(config).integrate(map, view, map_from_camera, stamp);
}

}  // namespace headway::nav
