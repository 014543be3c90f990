#include "app/voxel_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace headway::app {

using nav::Voxel;
using nav::VoxelMap;
using Index = VoxelMap::Index;

namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kEdge = VoxelMap::kBrickEdge;
}  // namespace

/// The state of one walk; lengths in voxels, positions counted from the map's lowest corner.
class VoxelRays::Walk {
 public:
  Walk(const VoxelRays& rays, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)
      : rays_(rays), map_(rays.map_), origin_(origin), direction_(direction) {}

  RayResult run() {
    if (!enter()) return result_;
    while (inside()) {
      const Index brick(voxel_.x() >> 3, voxel_.y() >> 3, voxel_.z() >> 3);
      const std::size_t number = map_.brick_index(brick);
      const nav::BrickSummary& summary = map_.summary(number);
      if (summary.unseen == VoxelMap::kBrickVoxels) {
        pass(Voxel::kUnseen);
        leave_brick(brick);
      } else if (summary.unseen == 0 && summary.occupied == 0) {
        pass(Voxel::kEmpty);
        leave_brick(brick);
      } else if (!walk_brick(number, brick)) {
        break;
      }
      if (before_ == Voxel::kEmpty) last_empty_ = t_;
    }
    return result_;
  }

 private:
  bool inside() const {
    return (voxel_.array() >= rays_.first_.array()).all() && (voxel_.array() < rays_.end_.array()).all();
  }

  /// To the first voxel of the box; false when the ray misses it.
  bool enter() {
    double t_in = 0, t_out = kInfinity;
    int axis_in = -1;
    for (int a = 0; a < 3; ++a) {
      const double low = rays_.first_[a], high = rays_.end_[a];
      step_[a] = direction_[a] >= 0 ? 1 : -1;
      if (std::abs(direction_[a]) < 1e-12) {
        if (origin_[a] < low || origin_[a] >= high) return false;
        continue;
      }
      const double t_low = (low - origin_[a]) / direction_[a], t_high = (high - origin_[a]) / direction_[a];
      if (std::min(t_low, t_high) > t_in) t_in = std::min(t_low, t_high), axis_in = a;
      t_out = std::min(t_out, std::max(t_low, t_high));
    }
    if (!(t_in < t_out)) return false;
    t_ = t_in;
    if (axis_in >= 0) axis_ = axis_in;
    place(rays_.first_, rays_.end_ - Index::Ones());
    if (axis_in >= 0) {
      voxel_[axis_in] = step_[axis_in] > 0 ? rays_.first_[axis_in] : rays_.end_[axis_in] - 1;
      aim();
    }
    return true;
  }

  /// Sets the voxel from t_, kept between two corners against rounding.
  void place(const Index& first, const Index& last) {
    const Eigen::Vector3d at = origin_ + t_ * direction_;
    voxel_ = at.array().floor().cast<int>().matrix().cwiseMax(first).cwiseMin(last);
    aim();
  }

  /// Where the ray would leave the voxel along each axis.
  void aim() {
    for (int a = 0; a < 3; ++a) {
      const double wall = voxel_[a] + (step_[a] > 0 ? 1 : 0);
      next_[a] = std::abs(direction_[a]) < 1e-12 ? kInfinity : (wall - origin_[a]) / direction_[a];
    }
  }

  void leave_brick(const Index& brick) {
    const Index first = kEdge * brick, last = first + Index::Constant(kEdge - 1);
    double t_out = kInfinity;
    for (int a = 0; a < 3; ++a) {
      if (std::abs(direction_[a]) < 1e-12) continue;
      const double wall = step_[a] > 0 ? last[a] + 1 : first[a];
      const double t = (wall - origin_[a]) / direction_[a];
      if (t < t_out) t_out = t, axis_ = a;
    }
    t_ = t_out;
    place(first, last);
    voxel_[axis_] = step_[axis_] > 0 ? last[axis_] + 1 : first[axis_] - 1;
    aim();
  }

  /// Voxel by voxel, to the brick's end; false when a surface was met.
  bool walk_brick(std::size_t number, const Index& brick) {
    const auto values = map_.values(number);
    while (inside() && (voxel_.x() >> 3) == brick.x() && (voxel_.y() >> 3) == brick.y() &&
           (voxel_.z() >> 3) == brick.z()) {
      const int at = VoxelMap::in_brick(voxel_.x() & 7, voxel_.y() & 7, voxel_.z() & 7);
      if (!pass(nav::voxel_of(values[static_cast<std::size_t>(at)]))) return false;
      step();
    }
    return true;
  }

  void step() {
    next_.minCoeff(&axis_);
    t_ = next_[axis_];
    voxel_[axis_] += step_[axis_];
    if (std::abs(direction_[axis_]) >= 1e-12) next_[axis_] += std::abs(1 / direction_[axis_]);
    if (before_ == Voxel::kEmpty) last_empty_ = t_;
  }

  /// Notes what the ray enters; false when it ends there.
  bool pass(Voxel state) {
    if (state == Voxel::kOccupied) {
      const bool seen_side = t_ - last_empty_ <= rays_.config_.gap / map_.resolution();
      // Once inside a wall from its back, its own thickness must not end the ray.
      if (before_ != Voxel::kOccupied) behind_ = !seen_side;
      if (!behind_ || !rays_.config_.seen_sides_only) {
        result_.surface = face();
        return false;
      }
    } else if (state == Voxel::kUnseen && before_ == Voxel::kEmpty && rays_.config_.veils &&
               result_.veil_count < RayResult::kMostVeils) {
      result_.veils[static_cast<std::size_t>(result_.veil_count++)] = face();
    }
    before_ = state;
    return true;
  }

  VoxelFace face() const { return {t_ * map_.resolution(), axis_, -step_[axis_], voxel_}; }

  const VoxelRays& rays_;
  const VoxelMap& map_;
  Eigen::Vector3d origin_, direction_;
  Eigen::Vector3d next_{0, 0, 0};
  Index voxel_{0, 0, 0}, step_{1, 1, 1};
  double t_ = 0, last_empty_ = -kInfinity;
  int axis_ = 2;
  Voxel before_ = Voxel::kUnseen;
  bool behind_ = false;
  RayResult result_;
};

VoxelRays::VoxelRays(const VoxelMap& map, const Config& config) : map_(map), config_(config) {
  const auto whole = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d inside = p.cwiseMax(map.lowest()).cwiseMin(map.highest());
    return Index(((inside - map.lowest()) / map.resolution()).array().round().cast<int>().matrix());
  };
  first_ = whole(config.lowest);
  end_ = whole(config.highest).cwiseMin(map.size());
}

RayResult VoxelRays::walk(const Eigen::Vector3d& eye, const Eigen::Vector3d& direction) const {
  return Walk(*this, (eye - map_.lowest()) / map_.resolution(), direction).run();
}

}  // namespace headway::app
