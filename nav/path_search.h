// The search itself, on whole numbers: states, motions and milliseconds.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "nav/blocked_motions.h"
#include "nav/bucket_queue.h"
#include "nav/floor_prices.h"

namespace headway::nav {

/// What the motions cost anywhere [ms].
struct MotionCosts {
  std::array<std::uint32_t, kConfigurations> walking{}, turning{};
  std::uint32_t mode_change = 0;

  MotionCosts(const PlannerConfig& config, const GaitLimits& gait, double resolution);
};

constexpr std::uint32_t kUnreachable = std::numeric_limits<std::uint32_t>::max();
constexpr int kLayers = 2 * kHeadings;

/// A* over states numbered cell * 16 + mode * 8 + heading, to one cell. Buffers are kept.
class PathSearch {
 public:
  struct Start {
    int heading = 0;
    std::uint32_t cost = 0;  ///< [ms]
  };
  struct Problem {
    int width = 0, height = 0;
    std::size_t start = 0, goal = 0;  ///< cells
    std::vector<Start> starts;        ///< in either mode
    std::array<std::uint32_t, kHeadings>
        arrival_cost{};  ///< by the heading at the goal; kUnreachable: not allowed
  };
  struct Found {
    std::vector<std::uint32_t> states, cost_so_far;  ///< from the start on [ms]
    std::uint32_t cost = 0;                          ///< with the arrival's [ms]
  };

  PathSearch(const MotionCosts& costs, const BlockedMotions& blocked, const FloorPrices& prices)
      : costs_(costs), blocked_(blocked), prices_(prices) {}

  /// The cheapest path, if there is one; of equally cheap ones always the same.
  std::optional<Found> run(const Problem& problem);

  /// After run() found none: cells that can be reached, as a flag each.
  const std::vector<std::uint8_t>& flood(const Problem& problem);

  std::size_t expansions() const { return expansions_; }

 private:
  void set_up(const Problem& problem);
  void measure_remaining(std::size_t goal);
  std::uint32_t cheapest_motion(std::size_t from, int direction) const;
  void reach(std::uint32_t state, std::uint32_t cost, std::uint8_t by);
  void expand(std::uint32_t state);
  template <class Visit>
  void for_each_motion(std::uint32_t state, const Visit& visit) const;
  Found trace(std::uint32_t last, std::uint32_t cost) const;
  std::uint32_t before(std::uint32_t state) const;

  const MotionCosts& costs_;
  const BlockedMotions& blocked_;
  const FloorPrices& prices_;

  int width_ = 0, height_ = 0;
  std::array<std::int64_t, kHeadings> next_cell_{};  ///< index offset of one cell on
  std::vector<std::uint32_t> remaining_;             ///< at least, by cell [ms]
  std::vector<std::uint32_t> so_far_;                ///< by state [ms]
  std::vector<std::uint8_t> reached_by_;             ///< motion 0..8, kModeChange or kBegun
  std::vector<std::uint8_t> flooded_;
  std::vector<std::uint32_t> stack_;
  BucketQueue open_;
  std::size_t expansions_ = 0;
};

}  // namespace headway::nav
