#include "runtime/localisation.h"

#include <algorithm>
#include <cmath>

#include "hal/on_floor.h"

namespace headway::runtime {
namespace {

constexpr double kStep = 0.1;  // [m] who has gone no farther stands still, and sways

}  // namespace

Localisation::Localisation(const LocalisationConfig& config, const nav::VoxelMap& map)
    : config_(config),
      map_(map),
      surfaces_(map.resolution()),
      localiser_(config.localise),
      drift_(config.drift) {
  config.patches.validate();
}

void Localisation::restore(const nav::SurfacePoints& surfaces) {
  if (!config_.use || surfaces.voxels() == 0) return;
  for (const nav::SurfaceVoxel& voxel : surfaces.saved()) surfaces_.restore(voxel);
  drift_.doubt_start(config_.start_shift, config_.start_turn);
  placed_ = false;
  restored_ = true;
}

void Localisation::see(const vision::RangeView& view, const Eigen::Isometry3d& odom_from_view,
                       const Eigen::Isometry3d& odom_from_chest, Time stamp,
                       const nav::PassingObstacles& passing) {
  alignment_ = {};
  if (!config_.use) return;
  nav::view_patches(view, config_.patches, patches_);
  odom_from_view_ = odom_from_view;
  const Pose2 stands = on_floor(odom_from_chest);
  if (!start_) start_ = stands;
  drift_.move(stands, stamp);
  leave_out(passing);
  if (drift_.covariance().isZero()) return;  // nothing can be off yet
  const Pose2 robot = drift_.map_from_robot();
  alignment_ = localiser_.align(map_, surfaces_, patches_, drift_.map_from_odom().lifted() * odom_from_view,
                                robot.position(), drift_.covariance());
  drift_.correct(alignment_);
  count();
  if (restored_ && (start_->position() - stands.position()).norm() < kStep)
    placed_ = (placed_ || (alignment_ && found_place())) && near_start();
  const Pose2 planned = steady_ * drift_.map_from_odom().inverse() * drift_.map_from_robot();
  const Pose2 now = drift_.map_from_robot();
  if ((planned.position() - now.position()).norm() > config_.steady_shift ||
      std::abs(wrap_angle(planned.yaw - now.yaw)) > config_.steady_turn)
    steady_ = drift_.map_from_odom();
}

void Localisation::leave_out(const nav::PassingObstacles& passing) {
  const Eigen::Isometry3d map_from_view = drift_.map_from_odom().lifted() * odom_from_view_;
  std::erase_if(patches_, [&](const nav::Patch& patch) {
    const Eigen::Vector3d point = map_from_view * patch.point;
    return point.z() < config_.lowest || passing.amid_free(point.head<2>());
  });
}

/// Known well enough for a view to become part of the map, which then helps to know it better.
bool Localisation::found_place() const {
  constexpr double kShift = 0.03, kTurn = 0.02;  // standard deviations [m, rad]
  const Eigen::Matrix3d& c = drift_.covariance();
  return std::max(c(0, 0), c(1, 1)) <= kShift * kShift && c(2, 2) <= kTurn * kTurn;
}

/// Not found where nobody would have set the robot up.
bool Localisation::near_start() const {
  constexpr double kSigmas = 4;
  const Pose2 moved = start_->inverse() * drift_.map_from_odom() * *start_;
  return moved.position().norm() <= kSigmas * config_.start_shift &&
         std::abs(moved.yaw) <= kSigmas * config_.start_turn;
}

void Localisation::learn() {
  if (!config_.use) return;
  const Eigen::Matrix3d& c = drift_.covariance();
  surfaces_.add(patches_, drift_.map_from_odom().lifted() * odom_from_view_, map_,
                {std::max(c(0, 0), c(1, 1)), c(2, 2)});
}

void Localisation::count() {
  if (alignment_.aligned == nav::Aligned::kWhole)
    ++counters_.whole;
  else if (alignment_)
    ++counters_.partly;
  else
    ++counters_.refused;
}

}  // namespace headway::runtime
