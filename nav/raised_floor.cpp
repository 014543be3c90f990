#include "nav/raised_floor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "hal/error.h"

namespace headway::nav {
namespace {

constexpr int kFewestPoints = 3;      // of a cell that have a vote
constexpr double kSigmas = 2.5;       // of a height that is known well, within the trip height
constexpr int kTallShare = 4;         // one in so many points above low, and it is not low
constexpr int kLevelShare = 10;       // fewer than one in so many that rises, and it is level
constexpr double kSurely = 2;         // sigmas that a point must lie above low
constexpr double kApart = 1 / 150.0;  // of the rays that are looked at, as tangents

}  // namespace

void RaisedFloorConfig::validate() const {
  const auto check = [](const char* name, double value, double lowest, double most) {
    if (value >= lowest && value <= most) return;
    throw InputError("raised floor: " + std::string(name) + ": " + std::to_string(value) + ", expected " +
                     std::to_string(lowest) + " to " + std::to_string(most));
  };
  check("trip_height", trip_height, 0, 0.5);
  check("low_height", low_height, 0, highest);
  check("highest", highest, trip_height, 1);
  check("tilt_sigma", tilt_sigma, 0, 0.1);
  check("nearest", nearest, 0, 5);
}

RaisedFloor::RaisedFloor(const FloorGrid& grid, const RaisedFloorConfig& config)
    : grid_(grid),
      config_(config),
      counts_(grid.size()),
      votes_(grid.size(), 0),
      tall_(grid.size(), 0),
      level_(grid.size(), 0) {
  config.validate();
}

void RaisedFloor::add(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera) {
  changed_.clear();
  if (config_.trip_height <= 0) return;
  count(view, map_from_camera);
  for (const Eigen::Vector2i& cell : counted_) {
    Count& c = counts_[grid_.index(cell)];
    if (c.points >= kFewestPoints) vote(cell, c);
    c = {};
  }
  counted_.clear();
}

/// The points of each cell whose height is known well, and those of them that rise.
void RaisedFloor::count(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera) {
  const Eigen::Vector3d eye = map_from_camera.translation();
  const int step = std::max(1, static_cast<int>(std::lround(view.camera.focal * kApart)));
  const double well = config_.trip_height / kSigmas;
  for (int v = 0; v < view.camera.height; v += step) {
    for (int u = 0; u < view.camera.width; u += step) {
      const std::size_t pixel = view.index(u, v);
      const auto depth = static_cast<double>(view.depth[pixel]);
      if (!(depth <= view.far)) continue;  // or nothing was measured
      const Eigen::Vector3d ray = map_from_camera.linear() * view.camera.point(u, v, 1);
      const double height = eye.z() + depth * ray.z();
      if (!(std::abs(height) <= config_.highest)) continue;
      const double away = depth * ray.head<2>().norm();
      const double sigma =
          std::hypot(static_cast<double>(view.sigma_depth[pixel]) * ray.z(), config_.tilt_sigma * away);
      if (sigma > well || away < config_.nearest) continue;
      const bool tall = height - kSurely * sigma > config_.low_height;
      count(grid_.cell(eye.head<2>() + depth * ray.head<2>()), height > config_.trip_height, tall);
    }
  }
}

void RaisedFloor::count(const Eigen::Vector2i& cell, bool high, bool tall) {
  if (!grid_.contains(cell)) return;
  Count& c = counts_[grid_.index(cell)];
  if (c.points == 0) counted_.push_back(cell);
  ++c.points;
  c.high = static_cast<std::uint16_t>(c.high + high);
  c.tall = static_cast<std::uint16_t>(c.tall + tall);
}

void RaisedFloor::vote(const Eigen::Vector2i& cell, const Count& count) {
  const std::size_t i = grid_.index(cell);
  const auto state = [&] { return std::array{raised(cell), low(cell), level(cell)}; };
  const auto before = state();
  const auto add = [](bool yes, std::uint8_t& votes) {
    if (yes && votes < kMost) ++votes;
    if (!yes && votes > 0) --votes;
  };
  add(2 * count.high > count.points, votes_[i]);
  add(kTallShare * count.tall > count.points, tall_[i]);
  const bool rises = kLevelShare * count.high > count.points;
  level_[i] =
      rises ? std::uint8_t{0} : std::min<std::uint8_t>(kMost, static_cast<std::uint8_t>(level_[i] + 1));
  if (before != state()) changed_.push_back(cell);
}

}  // namespace headway::nav
