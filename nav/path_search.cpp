#include "nav/path_search.h"

#include <algorithm>
#include <limits>

namespace headway::nav {

namespace {

/// The best way on from a state.
struct Next {
  std::uint32_t cost = kTooDear;  ///< to the goal, by way of this [ticks]
  Motion motion;
  Eigen::Vector2i cell{0, 0};
};

}  // namespace

std::optional<Motion> motion_between(const PathState& a, const PathState& b) {
  for (int number = 0; number < kMotions; ++number) {
    const Motion m{a.heading, number};
    if (a.mode == b.mode && m.mode() == a.mode && m.heading_after() == b.heading &&
        a.cell + cell_towards(m.direction()) == b.cell) {
      return m;
    }
  }
  return std::nullopt;
}

std::optional<PathSearch::Found> PathSearch::run(const CostQuery& query, std::size_t budget,
                                                 std::uint32_t expected) {
  constexpr auto kUnlimited = std::numeric_limits<std::size_t>::max();
  to_goal_.begin(query, expected);
  to_goal_.settle(kFirstWeight, kUnlimited);
  if (to_goal_.at_start() == kTooDear) return std::nullopt;
  const std::size_t first = to_goal_.relaxed();
  const bool best =
      budget > 0 && to_goal_.settle(16, budget < kUnlimited - first ? first + budget : kUnlimited);
  Found found = descend(query);
  found.bound = best ? 1 : kFirstWeight / 16.0;
  found.first_relaxed = first;
  found.relaxed = to_goal_.relaxed();
  return found;
}

/// From the start always to the best next state. A state's cost is never less than that of the best next
/// state and of the motion to it, so this ends, and costs no more than was known at the start.
PathSearch::Found PathSearch::descend(const CostQuery& query) const {
  const auto to_goal = [&](const Eigen::Vector2i& cell, int heading, Mode mode) {
    return to_goal_.at(cell.x(), cell.y(), layer_of(heading, mode));
  };
  const auto best_motion = [&](const PathState& s) {
    Next best;
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{s.heading, number};
      if (m.mode() != s.mode || floor_.blocked(s.cell.x(), s.cell.y(), m)) continue;
      const Eigen::Vector2i there = s.cell + cell_towards(m.direction());
      const std::uint32_t cost = to_goal(there, m.heading_after(), m.mode()) + std::uint32_t{costs_.of(m)} +
                                 floor_.price(s.cell.x(), s.cell.y(), m.direction() % 2 != 0);
      if (cost < best.cost) best = {cost, m, there};
    }
    return best;
  };

  PathState state{query.start, 0, Mode::kForward};
  std::uint32_t so_far = 0, least = std::numeric_limits<std::uint32_t>::max();
  for (int h = 0; h < kHeadings; ++h) {
    for (const Mode mode : {Mode::kForward, Mode::kSideway}) {
      const std::uint32_t turn = query.start_cost[static_cast<std::size_t>(h)];
      if (turn + to_goal(query.start, h, mode) >= least) continue;
      least = turn + to_goal(query.start, h, mode);
      so_far = turn;
      state.heading = h;
      state.mode = mode;
    }
  }
  Found found;
  for (;;) {
    found.states.push_back(state);
    found.cost_so_far.push_back(so_far);
    const Mode other_mode = state.mode == Mode::kForward ? Mode::kSideway : Mode::kForward;
    const Next same = best_motion(state), other = best_motion({state.cell, state.heading, other_mode});
    const Ticks arrival = query.arrival_cost(state.cell, state.heading);
    if (arrival != kTooDear && arrival <= std::min(same.cost, other.cost + costs_.mode_change)) {
      found.cost = so_far + arrival;
      return found;
    }
    const bool changes_mode = other.cost + costs_.mode_change < same.cost;
    if (changes_mode) {
      so_far += costs_.mode_change;
      state.mode = other_mode;
      found.states.push_back(state);
      found.cost_so_far.push_back(so_far);
    }
    const Next& next = changes_mode ? other : same;
    so_far += std::uint32_t{costs_.of(next.motion)} +
              floor_.price(state.cell.x(), state.cell.y(), next.motion.direction() % 2 != 0);
    state = {next.cell, next.motion.heading_after(), next.motion.mode()};
  }
}

}  // namespace headway::nav
