#include "runtime/mapper.h"

namespace headway::runtime {

Mapper::Mapper(const MapperConfig& config, const Pose2& start)
    : config_(config),
      start_(start),
      voxels_(config.voxels),
      integrator_(config.integration),
      floor_(nav::unseen_floor(nav::floor_grid(voxels_))) {
  project();
}

nav::IntegrationStats Mapper::integrate(const vision::RangeView& view,
                                        const Eigen::Isometry3d& map_from_camera,
                                        const Eigen::Isometry3d& map_from_chest, Time stamp) {
  // The chest sways by less than half a footprint while both feet stay where they are.
  const Eigen::Vector2d moved = map_from_chest.translation().head<2>() - start_.position();
  if (moved.norm() > config_.start_area.footprint_half.minCoeff()) at_start_ = false;
  return integrator_.integrate(voxels_, view, map_from_camera, stamp, map_from_chest);
}

void Mapper::project() {
  nav::floor_map(voxels_, config_.floor, floor_);
  nav::start_clear(floor_, start_, config_.start_area, Time{}, at_start_);
}

}  // namespace headway::runtime
