// The search for the cheapest path, on whole numbers: states, motions and ticks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "nav/cost_to_goal.h"
#include "nav/floor_chunks.h"
#include "nav/masks.h"
#include "nav/motion_costs.h"

namespace headway::nav {

/// The robot stands on the centre of a cell and faces 45 deg * heading.
struct PathState {
  Eigen::Vector2i cell{0, 0};
  int heading = 0;
  Mode mode = Mode::kForward;
  bool operator==(const PathState&) const = default;
};

/// The motion from one state of a path to the next; nothing when only the mode changes.
std::optional<Motion> motion_between(const PathState& a, const PathState& b);

/// A* whose lower bound of what remains is exact: it expands the states of the path and no others. What takes
/// the time is to find that bound, CostToGoal.
class PathSearch {
 public:
  struct Found {
    std::vector<PathState> states;               ///< from the start on
    std::vector<std::uint32_t> cost_so_far;      ///< at each, the first with its turn at the start [ticks]
    std::uint32_t cost = 0;                      ///< with the arrival's [ticks]
    double bound = 1;                            ///< no path costs less than cost / bound
    std::size_t first_relaxed = 0, relaxed = 0;  ///< chunks worked on until a path was known, and in all
  };

  /// Both must stay where they are; the floor's number of chunks may not change.
  PathSearch(const FloorChunks& floor, const MotionCosts& costs)
      : floor_(floor), costs_(costs), to_goal_(floor, costs) {}

  /// To be told after each change of the floor.
  void floor_changed(const FloorChanges& changes) { to_goal_.floor_changed(changes); }

  /// A path within 1.0625 of the cheapest, bettered while no more than `budget` further chunks are worked on;
  /// of equally cheap ones always the same. Nothing: there is none. `expected`: see CostToGoal::begin.
  std::optional<Found> run(const CostQuery& query, std::size_t budget, std::uint32_t expected = 0);

  const CostToGoal& to_goal() const { return to_goal_; }

  static constexpr int kFirstWeight = 17;  ///< sixteenths: 1.0625

 private:
  Found descend(const CostQuery& query) const;

  const FloorChunks& floor_;
  const MotionCosts& costs_;
  CostToGoal to_goal_;
};

}  // namespace headway::nav
