// The planner's problem as plainly as it can be said: A* with a binary heap and the octile distance, masks
// cell by cell, distances by looking at every cell around. The oracle of the tests and the peer of the
// benchmark.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>
#include <vector>

#include "nav/floor_map.h"
#include "nav/masks.h"
#include "nav/planner.h"
#include "nav/walking/gait.h"

namespace headway::nav {

/// The body's own place at the start counts for nothing here, and turns at either end meet nothing. Costs are
/// in ticks.
class TextbookSearch {
 public:
  static constexpr std::uint32_t kNoWay = std::numeric_limits<std::uint32_t>::max();

  TextbookSearch(const FloorMap& map, const PlannerConfig& config, const GaitLimits& gait, const Masks& masks)
      : grid_(map.grid), config_(config), gait_(gait), masks_(masks), obstacles_(map.grid.size()) {
    tick_ = gait.forward_seconds(grid_.resolution) / config.ticks_per_cell;
    for (std::size_t i = 0; i < grid_.size(); ++i) {
      const Floor floor = map.cells[i];
      obstacles_[i] =
          floor == Floor::kBlocked || (floor == Floor::kUnseen && config.unseen == UnseenFloor::kBlocked);
    }
    unseen_.resize(grid_.size());
    for (std::size_t i = 0; i < grid_.size(); ++i)
      unseen_[i] = config.unseen == UnseenFloor::kCostly && map.cells[i] == Floor::kUnseen;
    for (auto& p : prices_) p.assign(grid_.size(), kNotLookedAt);
    for (int diagonal = 0; diagonal < 2; ++diagonal) {
      for (int eighths = 0; eighths < 3; ++eighths) {
        const double length = grid_.resolution * (diagonal ? std::numbers::sqrt2 : 1);
        const double straight = length / gait.forward * to_seconds(gait.step_duration);
        const double aside =
            std::sin(eighths * kEighth) * length / gait.outward * 2 * to_seconds(gait.step_duration);
        forward_[diagonal][eighths] = ticks(straight) + turn(eighths * kEighth);
        sideway_[diagonal][eighths] = ticks(std::max(aside, std::cos(eighths * kEighth) * straight));
      }
    }
  }

  double tick() const { return tick_; }
  std::uint32_t turn(double angle) const {
    const double steps = std::abs(std::remainder(angle, 2 * std::numbers::pi)) / gait_.yaw;
    return ticks(config_.turn_price * steps * to_seconds(gait_.step_duration));
  }
  std::uint32_t mode_change() const { return ticks(config_.mode_change); }

  bool blocked(const Eigen::Vector2i& cell, const Motion& m) const {
    for (const Mask::Run& run : masks_.of(m).runs) {
      const int y = cell.y() + run.dy;
      if (y < 0 || y >= grid_.height || cell.x() + run.first < 0 || cell.x() + run.last >= grid_.width)
        return true;
      const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width);
      for (int x = cell.x() + run.first; x <= cell.x() + run.last; ++x)
        if (obstacles_[row + static_cast<std::size_t>(x)]) return true;
    }
    return false;
  }

  /// What a motion from a cell costs, the floor's price included.
  std::uint32_t motion(const Eigen::Vector2i& from, const Motion& m) const {
    const int diagonal = m.direction() % 2, eighths = std::abs(m.turn());
    return (m.mode() == Mode::kForward ? forward_ : sideway_)[diagonal][eighths] + price(from, diagonal != 0);
  }
  std::uint32_t price(const Eigen::Vector2i& cell, bool diagonal) const {
    const std::uint32_t& known = prices_[diagonal ? 1 : 0][grid_.index(cell)];
    if (known == kNotLookedAt) look_around(cell);
    return known;
  }

  /// The cheapest walk's cost; kNoWay when there is none.
  std::uint32_t cost(const Pose2& start, const Goal& goal) {
    const Eigen::Vector2i from = grid_.cell(start.position()), to = grid_.cell(goal.position);
    known_.assign(grid_.size() * 16, kNoWay);
    done_.assign(grid_.size() * 16, false);
    using Entry = std::pair<std::uint32_t, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    const auto reach = [&](const Eigen::Vector2i& c, int heading, Mode mode, std::uint32_t at) {
      const auto id = static_cast<std::uint32_t>(grid_.index(c)) * 16 + (mode == Mode::kForward ? 0u : 8u) +
                      static_cast<std::uint32_t>(heading);
      if (done_[id] || at >= known_[id]) return;
      known_[id] = at;
      open.push({at + at_least(c, to), id});
    };
    for (int h = 0; h < kHeadings; ++h)
      for (const Mode mode : {Mode::kForward, Mode::kSideway})
        reach(from, h, mode, turn(h * kEighth - start.yaw));
    std::uint32_t best = kNoWay;
    expansions_ = 0;
    while (!open.empty() && open.top().first < best) {
      const std::uint32_t id = open.top().second;
      open.pop();
      if (done_[id]) continue;
      done_[id] = true;
      ++expansions_;
      const std::uint32_t at = known_[id];
      const int cell = static_cast<int>(id / 16), heading = static_cast<int>(id % 8);
      const Mode mode = id & 8 ? Mode::kSideway : Mode::kForward;
      const Eigen::Vector2i c(cell % grid_.width, cell / grid_.width);
      if (c == to) best = std::min(best, at + (goal.yaw ? turn(*goal.yaw - heading * kEighth) : 0));
      reach(c, heading, mode == Mode::kForward ? Mode::kSideway : Mode::kForward, at + mode_change());
      for (int number = 0; number < kMotions; ++number) {
        const Motion m{heading, number};
        if (m.mode() != mode || blocked(c, m)) continue;
        reach(c + cell_towards(m.direction()), m.heading_after(), mode, at + motion(c, m));
      }
    }
    return best;
  }
  std::size_t expansions() const { return expansions_; }

 private:
  static constexpr double kEighth = std::numbers::pi / 4;

  std::uint32_t ticks(double seconds) const {
    return static_cast<std::uint32_t>(std::lround(seconds / tick_));
  }

  std::uint32_t at_least(const Eigen::Vector2i& from, const Eigen::Vector2i& to) const {
    const Eigen::Vector2i d = (to - from).cwiseAbs();
    const int both = d.minCoeff(), more = d.maxCoeff() - both;
    return static_cast<std::uint32_t>(more) * forward_[0][0] +
           static_cast<std::uint32_t>(both) * std::min(forward_[1][0], 2 * forward_[0][0]);
  }

  void look_around(const Eigen::Vector2i& c) const {
    const double size = grid_.resolution, range = config_.near_range;
    const int reach = static_cast<int>(range / size) + 1;
    double nearest = range;
    for (int y = std::max(0, c.y() - reach); y <= std::min(grid_.height - 1, c.y() + reach); ++y) {
      for (int x = std::max(0, c.x() - reach); x <= std::min(grid_.width - 1, c.x() + reach); ++x)
        if (obstacles_[grid_.index({x, y})])
          nearest = std::min(nearest, std::hypot(x - c.x(), y - c.y()) * size);
    }
    const double near = range > 0 ? config_.near_price * (1 - nearest / range) : 0;
    const double on_it = range > 0 || !obstacles_[grid_.index(c)] ? near : config_.near_price;
    const int half = static_cast<int>(config_.corridor / size + 1e-6);
    int unseen = 0;
    for (int y = -half; y <= half; ++y)
      for (int x = -half; x <= half; ++x)
        unseen += grid_.contains({c.x() + x, c.y() + y}) && unseen_[grid_.index({c.x() + x, c.y() + y})];
    const double share = config_.unseen_price * unseen / ((2 * half + 1) * (2 * half + 1));
    for (int diagonal = 0; diagonal < 2; ++diagonal) {
      const double straight = gait_.forward_seconds(size * (diagonal ? std::numbers::sqrt2 : 1));
      prices_[diagonal][grid_.index(c)] = ticks(on_it * straight) + ticks(share * straight);
    }
  }

  FloorGrid grid_;
  PlannerConfig config_;
  GaitLimits gait_;
  const Masks& masks_;
  double tick_;
  static constexpr std::uint32_t kNotLookedAt = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint8_t> obstacles_, unseen_;
  mutable std::array<std::vector<std::uint32_t>, 2>
      prices_;                                   // [diagonal][cell], of cells that were asked for
  std::uint32_t forward_[2][3], sideway_[2][3];  // [diagonal][eighths turned, or off the heading]
  std::vector<std::uint32_t> known_;             // by state
  std::vector<bool> done_;
  std::size_t expansions_ = 0;
};

}  // namespace headway::nav
