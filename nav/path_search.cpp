#include "nav/path_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace headway::nav {

namespace {

constexpr std::uint8_t kModeChange = kMotions, kBegun = kMotions + 1;
constexpr std::uint32_t kSidewayBit = kHeadings;

std::size_t cell_of(std::uint32_t state) { return state / kLayers; }
int heading_of(std::uint32_t state) { return static_cast<int>(state % kHeadings); }
bool is_sideway(std::uint32_t state) { return (state & kSidewayBit) != 0; }
std::uint32_t state_of(std::size_t cell, int heading, bool sideway) {
  return static_cast<std::uint32_t>(cell) * kLayers + (sideway ? kSidewayBit : 0) +
         static_cast<std::uint32_t>(heading);
}

}  // namespace

MotionCosts::MotionCosts(const PlannerConfig& config, const GaitLimits& gait, double resolution)
    : mode_change(milliseconds(config.mode_change)) {
  for (int heading = 0; heading < kHeadings; ++heading) {
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{heading, number};
      const auto c = static_cast<std::size_t>(m.configuration());
      const double angle = std::abs(m.turn()) * std::numbers::pi / 4;
      const double length = resolution * (m.direction() % 2 == 0 ? 1 : std::numbers::sqrt2);
      if (m.mode() == Mode::kForward) {
        walking[c] = milliseconds(gait.forward_seconds(length));
        turning[c] = milliseconds(config.turn_price * gait.turn_seconds(angle));
      } else {
        walking[c] = milliseconds(std::max(gait.sideway_seconds(length * std::sin(angle)),
                                           gait.forward_seconds(length * std::cos(angle))));
      }
    }
  }
}

void PathSearch::set_up(const Problem& problem) {
  width_ = problem.width;
  height_ = problem.height;
  for (int d = 0; d < kHeadings; ++d) {
    const Eigen::Vector2i way = cell_towards(d);
    next_cell_[static_cast<std::size_t>(d)] = way.y() * width_ + way.x();
  }
  const std::size_t cells = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  so_far_.assign(cells * kLayers, kUnreachable);
  reached_by_.resize(cells * kLayers);
  expansions_ = 0;
}

/// The least that any unblocked motion costs from a cell in a direction, prices of the floor left out.
std::uint32_t PathSearch::cheapest_motion(std::size_t from, int direction) const {
  // In rising order of cost: straight on, sideways, with a turn of one eighth, of two.
  struct Way {
    int turn, number;
  };
  static constexpr std::array<Way, kMotions> kWays{
      {{0, 2}, {-1, 6}, {1, 7}, {-2, 5}, {2, 8}, {-1, 1}, {1, 3}, {-2, 0}, {2, 4}}};
  std::uint32_t least = kUnreachable;
  for (const Way& way : kWays) {
    const int heading = (direction - way.turn) & 7;
    if (blocked_.at(from, heading) >> way.number & 1) continue;
    const auto c = static_cast<std::size_t>(Motion{heading, way.number}.configuration());
    least = std::min(least, costs_.walking[c] + costs_.turning[c]);
    if (way.turn == 0) break;
  }
  return least;
}

/// Dijkstra from the goal over cells alone: no walk through these obstacles can cost less, whatever its
/// headings.
void PathSearch::measure_remaining(std::size_t goal) {
  remaining_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kUnreachable);
  open_.clear(0);
  remaining_[goal] = 0;
  open_.push(0, static_cast<std::uint32_t>(goal));
  while (const auto entry = open_.pop()) {
    const std::size_t to = entry->item;
    if (remaining_[to] != entry->key) continue;
    const int x = static_cast<int>(to % static_cast<std::size_t>(width_));
    const int y = static_cast<int>(to / static_cast<std::size_t>(width_));
    for (int d = 0; d < kHeadings; ++d) {
      const Eigen::Vector2i way = cell_towards(d);
      const int from_x = x - way.x(), from_y = y - way.y();
      if (from_x < 0 || from_y < 0 || from_x >= width_ || from_y >= height_) continue;
      const auto from = static_cast<std::size_t>(from_y * width_ + from_x);
      const std::uint32_t known = entry->key + prices_.total(to, d % 2 != 0);
      if (remaining_[from] <= known) continue;
      const std::uint32_t motion = cheapest_motion(from, d);
      if (motion == kUnreachable || remaining_[from] <= known + motion) continue;
      remaining_[from] = known + motion;
      open_.push(known + motion, static_cast<std::uint32_t>(from));
    }
  }
}

template <class Visit>
void PathSearch::for_each_motion(std::uint32_t state, const Visit& visit) const {
  const std::size_t cell = cell_of(state);
  const int heading = heading_of(state);
  const bool sideway = is_sideway(state);
  const int first = sideway ? kForwardMotions : 0, last = sideway ? kMotions : kForwardMotions;
  const unsigned blocked = blocked_.at(cell, heading);
  for (int number = first; number < last; ++number) {
    if (blocked >> number & 1) continue;
    const Motion m{heading, number};
    const int direction = m.direction();
    const auto to = static_cast<std::size_t>(static_cast<std::int64_t>(cell) +
                                             next_cell_[static_cast<std::size_t>(direction)]);
    visit(m, to, direction);
  }
}

void PathSearch::reach(std::uint32_t state, std::uint32_t cost, std::uint8_t by) {
  if (cost >= so_far_[state]) return;
  const std::uint32_t remaining = remaining_[cell_of(state)];
  if (remaining == kUnreachable) return;
  so_far_[state] = cost;
  reached_by_[state] = by;
  open_.push(cost + remaining, state);
}

void PathSearch::expand(std::uint32_t state) {
  ++expansions_;
  const std::uint32_t cost = so_far_[state];
  for_each_motion(state, [&](const Motion& m, std::size_t to, int direction) {
    const auto c = static_cast<std::size_t>(m.configuration());
    const std::uint32_t motion =
        costs_.walking[c] + costs_.turning[c] + prices_.total(to, direction % 2 != 0);
    reach(state_of(to, m.heading_after(), is_sideway(state)), cost + motion,
          static_cast<std::uint8_t>(m.number));
  });
  reach(state ^ kSidewayBit, cost + costs_.mode_change, kModeChange);
}

std::optional<PathSearch::Found> PathSearch::run(const Problem& problem) {
  set_up(problem);
  measure_remaining(problem.goal);
  open_.clear(remaining_[problem.start] == kUnreachable ? 0 : remaining_[problem.start]);
  for (const Start& s : problem.starts) {
    for (const bool sideway : {false, true}) {
      reach(state_of(problem.start, s.heading, sideway), s.cost, kBegun);
    }
  }
  std::uint32_t best = kUnreachable, best_state = 0;
  while (const auto entry = open_.pop()) {
    if (entry->key >= best) break;
    const std::uint32_t state = entry->item;
    if (so_far_[state] + remaining_[cell_of(state)] != entry->key) continue;
    if (cell_of(state) == problem.goal) {
      const std::uint32_t arrival = problem.arrival_cost[static_cast<std::size_t>(heading_of(state))];
      if (arrival != kUnreachable && so_far_[state] + arrival < best) {
        best = so_far_[state] + arrival;
        best_state = state;
      }
    }
    expand(state);
  }
  if (best == kUnreachable) return std::nullopt;
  return trace(best_state, best);
}

/// The state from which this one was reached.
std::uint32_t PathSearch::before(std::uint32_t state) const {
  const std::uint8_t by = reached_by_[state];
  if (by == kModeChange) return state ^ kSidewayBit;
  // Sideway motions keep the heading; forward ones end with the heading they go in.
  const int turn = Motion{0, by}.turn();
  const int heading = is_sideway(state) ? heading_of(state) : (heading_of(state) - turn) & 7;
  const auto direction = static_cast<std::size_t>((heading + turn) & 7);
  const auto cell =
      static_cast<std::size_t>(static_cast<std::int64_t>(cell_of(state)) - next_cell_[direction]);
  return state_of(cell, heading, is_sideway(state));
}

PathSearch::Found PathSearch::trace(std::uint32_t last, std::uint32_t cost) const {
  Found found;
  found.cost = cost;
  for (std::uint32_t state = last;; state = before(state)) {
    found.states.push_back(state);
    found.cost_so_far.push_back(so_far_[state]);
    if (reached_by_[state] == kBegun) break;
  }
  std::reverse(found.states.begin(), found.states.end());
  std::reverse(found.cost_so_far.begin(), found.cost_so_far.end());
  return found;
}

const std::vector<std::uint8_t>& PathSearch::flood(const Problem& problem) {
  set_up(problem);
  flooded_.assign(so_far_.size() / kLayers, 0);
  stack_.clear();
  const auto arrive = [&](std::uint32_t state) {
    if (so_far_[state] == 0) return;
    so_far_[state] = 0;
    flooded_[cell_of(state)] = 1;
    stack_.push_back(state);
  };
  for (const Start& s : problem.starts) arrive(state_of(problem.start, s.heading, false));
  while (!stack_.empty()) {
    const std::uint32_t state = stack_.back();
    stack_.pop_back();
    for_each_motion(state, [&](const Motion& m, std::size_t to, int) {
      arrive(state_of(to, m.heading_after(), is_sideway(state)));
    });
    arrive(state ^ kSidewayBit);
  }
  return flooded_;
}

}  // namespace headway::nav
