#include "nav/next_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "hal/error.h"

namespace headway::nav {
namespace {

using hal::HeadAngles, hal::HeadLimits;

void sort_by_rate(std::vector<NextLook>& looks) {
  std::stable_sort(looks.begin(), looks.end(),
                   [](const NextLook& a, const NextLook& b) { return a.rate() > b.rate(); });
}

// Trapezoid of velocity, or a triangle where the way is short.
double joint_seconds(double way, const HeadLimits& limits) {
  const double v = limits.velocity, a = limits.acceleration;
  return way * a > v * v ? way / v + v / a : 2 * std::sqrt(way / a);
}

// From end to end, no more than `step` apart.
std::vector<double> spread(double lower, double upper, double step) {
  const int parts = std::max(1, static_cast<int>(std::ceil((upper - lower) / step - 1e-9)));
  std::vector<double> angles;
  for (int i = 0; i <= parts; ++i) angles.push_back(std::lerp(lower, upper, static_cast<double>(i) / parts));
  return angles;
}

// Half of the field's opening angle along one axis, at its far end.
double half_field(const vision::Polytope& field, int axis) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Eigen::Vector3d& corner : field.corners) {
    low = std::min(low, std::atan2(corner[axis], corner.z()));
    high = std::max(high, std::atan2(corner[axis], corner.z()));
  }
  return std::max(0.05, (high - low) / 2);
}

// No walk takes less.
double least_seconds(const Pose2& from, const Pose2& to, const GaitLimits& gait) {
  return std::max(gait.forward_seconds((to.position() - from.position()).norm()),
                  gait.turn_seconds(wrap_angle(to.yaw - from.yaw)));
}

std::vector<Pose2> stances_around(const Pose2& base, const FloorMap& floor, const NextViewConfig& config) {
  const int reach = static_cast<int>(config.stance_range / config.stance_spacing);
  std::vector<Pose2> stances;
  for (int j = -reach; j <= reach; ++j)
    for (int i = -reach; i <= reach; ++i) {
      const Eigen::Vector2d way = config.stance_spacing * Eigen::Vector2d(i, j);
      const Eigen::Vector2d place = base.position() + way;
      if (way.norm() > config.stance_range || floor.at(floor.grid.cell(place)) != Floor::kFree) continue;
      for (int heading = 0; heading < 8; ++heading) {
        const Pose2 stance{place.x(), place.y(), wrap_angle(heading * std::numbers::pi / 4)};
        const bool is_there = i == 0 && j == 0 && std::abs(wrap_angle(stance.yaw - base.yaw)) < 0.01;
        if (!is_there) stances.push_back(stance);
      }
    }
  return stances;
}

}  // namespace

void NextViewConfig::validate() const {
  const auto check = [](const char* key, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    throw InputError("next view: " + std::string(key) + ": is " + std::to_string(value) + ", expected " +
                     std::to_string(lowest) + " to " + std::to_string(highest));
  };
  check("least_gain", least_gain, 1e-6, 1000);
  check("look_seconds", look_seconds, 0.01, 60);
  check("stance_spacing", stance_spacing, 0.05, 10);
  check("stance_range", stance_range, 0, 20);
}

double head_seconds(const HeadAngles& from, const HeadAngles& to, const HeadLimits& limits) {
  return std::max(joint_seconds(std::abs(to.pan - from.pan), limits),
                  joint_seconds(std::abs(to.tilt - from.tilt), limits));
}

NextView::NextView(const Viewer& viewer, double resolution, const NextViewConfig& config)
    : viewer_(viewer), config_(config), gain_(viewer.field, resolution, config.space) {
  config.validate();
  const HeadLimits& limits = viewer.head;
  tilts_ = spread(limits.lower.tilt, limits.upper.tilt, half_field(viewer.field, 1));
  for (const double tilt : tilts_)
    for (const double pan : spread(limits.lower.pan, limits.upper.pan, half_field(viewer.field, 0)))
      directions_.push_back({pan, tilt});
}

double NextView::gain(const VoxelMap& map, const Eigen::Isometry3d& map_from_chest, const HeadAngles& head,
                      std::span<const Eigen::Isometry3d> looked) {
  const std::size_t voxels = gain_.gain(map, map_from_chest * viewer_.neck.chest_from_camera(head), looked);
  return static_cast<double>(voxels) * std::pow(map.resolution(), 3);
}

std::vector<NextLook> NextView::turns(const VoxelMap& map, const Eigen::Isometry3d& map_from_chest,
                                      const HeadAngles& head, std::span<const Eigen::Isometry3d> looked) {
  std::vector<NextLook> looks;
  for (const HeadAngles& direction : directions_) {
    const double gain = this->gain(map, map_from_chest, direction, looked);
    if (gain < config_.least_gain) continue;
    looks.push_back(
        {direction, {}, gain, head_seconds(head, direction, viewer_.head) + config_.look_seconds});
  }
  sort_by_rate(looks);
  return looks;
}

NextLook NextView::best_ahead(const VoxelMap& map, const Pose2& stance) {
  NextLook best{{}, stance, 0, config_.look_seconds};
  const double pan = std::clamp(0.0, viewer_.head.lower.pan, viewer_.head.upper.pan);
  for (const double tilt : tilts_) {
    const double gain = this->gain(map, stance.lifted(viewer_.chest_height), {pan, tilt}, {});
    if (gain <= best.gain) continue;
    best.gain = gain;
    best.head = {pan, tilt};
  }
  return best;
}

std::vector<NextLook> NextView::walks(const VoxelMap& map, const FloorMap& floor, Planner& planner,
                                      const GaitLimits& gait, const Pose2& base, std::size_t most) {
  std::vector<NextLook> hoped;
  for (const Pose2& stance : stances_around(base, floor, config_)) {
    hoped.push_back(best_ahead(map, stance));
    hoped.back().seconds += least_seconds(base, stance, gait);
  }
  std::erase_if(hoped, [&](const NextLook& look) { return look.gain < config_.least_gain; });
  sort_by_rate(hoped);
  std::vector<NextLook> looks;
  for (NextLook look : hoped) {
    // What follows cannot be better than it is hoped to be.
    if (looks.size() >= most && looks[most - 1].rate() >= look.rate()) break;
    const PlanResult way = planner.plan(floor, base, {look.stance->position(), look.stance->yaw, 0});
    if (!way) continue;
    const PathCost& cost = way.path.cost;
    look.seconds = config_.look_seconds + cost.walking + cost.turning + cost.mode_changes;
    looks.push_back(look);
    sort_by_rate(looks);
  }
  looks.resize(std::min(looks.size(), most));
  return looks;
}

}  // namespace headway::nav
