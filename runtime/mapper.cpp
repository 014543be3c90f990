#include "runtime/mapper.h"

#include <cmath>
#include <string>

#include "hal/error.h"

namespace headway::runtime {
namespace {

constexpr double kClose = 1.2;  // of the robot, along x and y: there it must be known what is low [m]

/// As much of the box as the window holds, at its lowest corner.
nav::VoxelMapConfig first_window(const MapperConfig& config) {
  nav::VoxelMapConfig window = config.voxels;
  if (config.window <= 0) return window;
  const nav::BrickRange box = nav::bricks_in(config.voxels);
  const double brick = config.voxels.resolution * nav::kBrickEdge;
  for (const int axis : {0, 1}) {
    const double end = box.first[axis] + std::ceil(config.window / brick);
    if (end < box.end[axis]) {
      window.lowest[axis] = box.first[axis] * brick;
      window.highest[axis] = end * brick;
    }
  }
  return window;
}

}  // namespace

Mapper::Mapper(const MapperConfig& config, const Pose2& start)
    : config_(config),
      start_(start),
      voxels_(first_window(config)),
      aside_(config.voxels.resolution),
      integrator_(config.integration),
      raised_(nav::floor_grid(config.voxels), config.raised_floor),
      projection_(nav::floor_grid(config.voxels), config.floor),
      floor_(nav::unseen_floor(nav::floor_grid(config.voxels))),
      passing_(floor_.grid, config.floor) {
  follow({start.x, start.y, 0});
  project();
}

// The window stays within the box, and moves only when the robot is a brick off its middle, so that swaying
// does not move it to and fro.
void Mapper::follow(const Eigen::Vector3d& robot) {
  const double brick = voxels_.resolution() * nav::kBrickEdge;
  const nav::BrickRange box = this->box();
  const Eigen::Array3d half = (voxels_.highest() - voxels_.lowest()).array() / 2,
                       low = box.first.cast<double>().array() * brick + half,
                       high = box.end.cast<double>().array() * brick - half;
  const Eigen::Vector3d middle = (voxels_.highest() + voxels_.lowest()) / 2,
                        wanted = robot.array().min(high).max(low);
  if ((wanted - middle).lpNorm<Eigen::Infinity>() > brick) voxels_.roll_to(wanted, &aside_);
}

void Mapper::restore(const nav::ColdMap& known) {
  if (known.resolution() != voxels_.resolution())
    throw InputError("the map's voxels have edges of " + std::to_string(known.resolution()) +
                     " m, expected the robot's " + std::to_string(voxels_.resolution()));
  known.for_any(
      [&](const nav::BrickKey& key, const nav::BrickValues& values) { aside_.keep(key, values, {}); });
  show_all_to_the_window();
}

/// The floor is projected from the window only, and what is known comes into it when it moves there.
void Mapper::show_all_to_the_window() {
  const double brick = voxels_.resolution() * nav::kBrickEdge;
  const nav::BrickRange box = this->box();
  const Eigen::Vector3d size = voxels_.highest() - voxels_.lowest(), home = voxels_.lowest() + size / 2,
                        first = box.first.cast<double>() * brick + size / 2,
                        end = box.end.cast<double>() * brick + size / 2;
  voxels_.roll_to(first - size, &aside_);
  for (double y = first.y(); y < end.y(); y += size.y()) {
    for (double x = first.x(); x < end.x(); x += size.x()) {
      voxels_.roll_to({x, y, first.z()}, &aside_);
      project();
    }
  }
  voxels_.roll_to(home, &aside_);
  project();
}

nav::ColdMap Mapper::everything() const {
  nav::ColdMap all = aside_.map();
  for (std::size_t b = 0; b < voxels_.brick_count(); ++b)
    if (voxels_.summary(b).unseen < nav::kBrickVoxels)
      all.put(voxels_.key(voxels_.brick_at(b)), voxels_.values(b));
  return all;
}

nav::IntegrationStats Mapper::integrate(const vision::RangeView& view,
                                        const Eigen::Isometry3d& map_from_camera,
                                        const Eigen::Isometry3d& map_from_chest, Time stamp) {
  // The chest sways by less than half a footprint while both feet stay where they are.
  const Eigen::Vector2d moved = map_from_chest.translation().head<2>() - start_.position();
  if (moved.norm() > config_.start_area.footprint_half.minCoeff()) at_start_ = false;
  follow(map_from_chest.translation());
  if (config_.floor.step_over > 0) {
    const Eigen::Vector2d at = map_from_chest.translation().head<2>(), far(kClose, kClose);
    projection_.look_closely_within({floor_.grid.cell(at - far), floor_.grid.cell(at + far)});
  }
  raised_.add(view, map_from_camera);
  passing_.look(view, map_from_camera, stamp);
  for (const Eigen::Vector2i& cell : raised_.changed()) {
    using Rise = nav::FloorProjection::Rise;
    projection_.set_rise(cell, raised_.low(cell)      ? Rise::kLow
                               : raised_.raised(cell) ? Rise::kHigh
                               : raised_.level(cell)  ? Rise::kLevel
                                                      : Rise::kUnknown);
    if (raised_.raised(cell)) passing_.stands(cell, stamp);
  }
  return integrator_.integrate(voxels_, view, map_from_camera, stamp, map_from_chest);
}

void Mapper::project() {
  projection_.again(nav::start_cells(floor_.grid, start_, config_.start_area));
  projection_.update(voxels_, floor_);
  passing_.see(floor_);
  nav::start_clear(floor_, start_, config_.start_area, Time{}, at_start_);
}

}  // namespace headway::runtime
