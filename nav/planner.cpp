#include "nav/planner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>
#include <utility>

#include "nav/reachable.h"
#include "nav/surveyed_floor.h"
#include "nav/turn_room.h"

namespace headway::nav {

using Eigen::Vector2d;
using Eigen::Vector2i;

const char* describe(NoPath reason) {
  switch (reason) {
    case NoPath::kNone:
      return "there is a path";
    case NoPath::kStartBlocked:
      return "the robot cannot move from where it stands";
    case NoPath::kGoalBlocked:
      return "the robot does not fit at the goal";
    case NoPath::kGoalOutside:
      return "the goal is not on the map";
    case NoPath::kTooFar:
      return "the way to the goal is too long";
    case NoPath::kEnclosed:
      return "obstacles close every way to the goal";
  }
  return "";
}

std::string describe_shortfall(const PlanResult& result, const Goal& goal) {
  if (!result || result.short_of_goal == NoPath::kNone) return {};
  const Vector2d& end = result.path.end;
  char line[160];
  std::snprintf(line, sizeof line, "as near as it gets, (%.2f, %.2f), %.2f m from the goal: %s", end.x(),
                end.y(), (end - goal.position).norm(), describe(result.short_of_goal));
  return line;
}

class Planner::Search {
 public:
  Search(const PlannerConfig& config, const GaitLimits& gait, const BodyOutline& outline, double resolution)
      : config_(config),
        gait_(gait),
        outline_(outline),
        resolution_(resolution),
        masks_(outline, resolution),
        bare_masks_(outline.bare(), resolution),
        costs_(config, gait, resolution),
        floor_(masks_, bare_masks_, FloorPrices(config, gait, resolution, costs_.tick), config.unseen) {}
  // The search refers to its siblings.
  Search(const Search&) = delete;
  Search& operator=(const Search&) = delete;

  PlanResult plan(const FloorMap& map, const Pose2& start, const Goal& goal);
  const Masks& masks() const { return masks_; }
  double tick() const { return costs_.tick; }
  std::size_t bytes() const { return floor_.bytes() + (search_ ? search_->to_goal().bytes() : 0); }
  void forget();

 private:
  struct End {
    Vector2d position;
    std::optional<double> yaw;
  };

  GroundView view(const FloorMap& map, const Pose2& start) const {
    return {map, config_.unseen, outline_, start, config_.start_is_free};
  }
  Ticks turn_cost(double angle) const {
    return in_ticks(config_.turn_price * gait_.turn_seconds(angle), costs_.tick);
  }
  bool stands(const GroundView& ground, const Vector2i& cell, int heading) const;
  std::optional<End> choose_end(const GroundView& ground, const Goal& goal);
  std::optional<End> nearest_end(const GroundView& ground, const Pose2& start, const Goal& goal);
  PlanResult plan_to(const FloorMap& map, const GroundView& ground, const Pose2& start, const Goal& goal);
  PlanResult go(const FloorMap& map, const GroundView& ground, const Pose2& start, const End& end);
  void survey(const FloorMap& map, const GroundView& ground);
  bool can_end(const GroundView& ground, const Vector2i& cell, const End& end);
  bool stays(const GroundView& ground, const Pose2& start, const End& end) const;
  Path stay(const FloorGrid& grid, const Pose2& start, const End& end) const;
  unsigned list_starts(const GroundView& ground, const Pose2& start);
  PlanResult search(const FloorMap& map, const Pose2& start, const End& end, unsigned headings);
  PlanResult explain_no_path(const FloorGrid& grid, const Vector2d& goal, unsigned headings);
  std::uint32_t expected_cost() const;
  Path path_of(PathSearch::Found found, const Pose2& start, const End& end) const;
  PathCost shares(const Path& path) const;

  PlannerConfig config_;
  GaitLimits gait_;
  BodyOutline outline_;
  double resolution_;
  Masks masks_, bare_masks_;
  MotionCosts costs_;
  SurveyedFloor floor_;
  std::optional<PathSearch> search_;  ///< for rasters of the floor's size
  CostQuery query_;
  struct Last {
    Vector2i goal;
    std::uint32_t cost;
  };
  std::optional<Last> last_;
  std::unique_ptr<Search> coarser_;  ///< for walks so long that costs do not fit
};

bool Planner::Search::stands(const GroundView& ground, const Vector2i& cell, int heading) const {
  return !ground.blocks(cell, masks_.standing(heading), bare_masks_.standing(heading));
}

/// Whether the robot can come to rest there, and what its last turn costs from each heading.
bool Planner::Search::can_end(const GroundView& ground, const Vector2i& cell, const End& end) {
  bool any = false;
  const TurnRoom room(ground, outline_, end.position);
  for (int h = 0; h < kHeadings; ++h) {
    const double heading = heading_angle(h);
    const bool can = stands(ground, cell, h) && (!end.yaw || room.can_turn(heading, *end.yaw));
    const Ticks turn = end.yaw ? turn_cost(wrap_angle(*end.yaw - heading)) : Ticks{0};
    query_.arrival_cost[static_cast<std::size_t>(h)] = can ? turn : kTooDear;
    any |= can;
  }
  return any;
}

/// The goal's own position, else the middle of the nearest cell within tolerance where the body fits.
std::optional<Planner::Search::End> Planner::Search::choose_end(const GroundView& ground, const Goal& goal) {
  const FloorGrid& grid = ground.grid();
  const Vector2i own = grid.cell(goal.position);
  if (can_end(ground, own, {goal.position, goal.yaw})) return End{goal.position, goal.yaw};
  std::vector<std::pair<double, Vector2i>> others;
  const int around = static_cast<int>(goal.tolerance / grid.resolution) + 1;
  for (int y = own.y() - around; y <= own.y() + around; ++y) {
    for (int x = own.x() - around; x <= own.x() + around; ++x) {
      const double distance = (grid.centre({x, y}) - goal.position).norm();
      if (grid.contains({x, y}) && distance <= goal.tolerance) others.push_back({distance, {x, y}});
    }
  }
  std::stable_sort(others.begin(), others.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [distance, cell] : others) {
    const End end{grid.centre(cell), goal.yaw};
    if (can_end(ground, cell, end)) return end;
  }
  return std::nullopt;
}

/// The middle of the reachable cell nearest to the goal where the robot can come to rest, facing as wished;
/// of equally near ones the first in the map.
std::optional<Planner::Search::End> Planner::Search::nearest_end(const GroundView& ground, const Pose2& start,
                                                                 const Goal& goal) {
  const FloorGrid& grid = ground.grid();
  const auto reached =
      reachable_headings(floor_.chunks(), grid.cell(start.position()), list_starts(ground, start));
  const auto cell_at = [&](std::size_t i) {
    const auto width = static_cast<std::size_t>(grid.width);
    return Vector2i(static_cast<int>(i % width), static_cast<int>(i / width));
  };
  std::vector<std::pair<double, std::size_t>> places;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached[i] != 0) places.emplace_back((grid.centre(cell_at(i)) - goal.position).norm(), i);
  }
  if (places.size() <= 1) return std::nullopt;  // it cannot move
  const auto farther = std::greater<>();
  std::make_heap(places.begin(), places.end(), farther);
  for (auto end = places.end(); end != places.begin(); --end) {
    std::pop_heap(places.begin(), end, farther);
    const std::size_t i = (end - 1)->second;
    const Vector2i cell = cell_at(i);
    const End place{grid.centre(cell), goal.yaw};
    if (!can_end(ground, cell, place)) continue;
    for (int h = 0; h < kHeadings; ++h)
      if ((reached[i] >> h & 1) && query_.arrival_cost[static_cast<std::size_t>(h)] != kTooDear) return place;
  }
  return std::nullopt;
}

/// Already there, or only to turn.
bool Planner::Search::stays(const GroundView& ground, const Pose2& start, const End& end) const {
  if (ground.grid().cell(start.position()) != ground.grid().cell(end.position)) return false;
  return !end.yaw || TurnRoom(ground, outline_, start.position()).can_turn(start.yaw, *end.yaw);
}

Path Planner::Search::stay(const FloorGrid& grid, const Pose2& start, const End& end) const {
  const double yaw = end.yaw.value_or(start.yaw);
  const int heading = static_cast<int>(std::lround(yaw / (std::numbers::pi / 4))) & 7;
  Path path;
  path.start = start;
  path.states = {{grid.cell(end.position), heading, Mode::kForward}};
  path.cost_so_far_s = {0};
  path.cost.turning = turn_cost(wrap_angle(yaw - start.yaw)) * costs_.tick;
  path.cost_s = path.cost.total();
  path.end = end.position;
  path.end_yaw = end.yaw;
  return path;
}

/// The headings to which the robot can turn where it stands.
unsigned Planner::Search::list_starts(const GroundView& ground, const Pose2& start) {
  unsigned headings = 0;
  const TurnRoom room(ground, outline_, start.position());
  for (int h = 0; h < kHeadings; ++h) {
    const bool can = room.can_turn(start.yaw, heading_angle(h));
    query_.start_cost[static_cast<std::size_t>(h)] =
        can ? turn_cost(wrap_angle(heading_angle(h) - start.yaw)) : kTooDear;
    headings |= static_cast<unsigned>(can) << h;
  }
  return headings;
}

/// The last path's cost and what a detour of some metres adds, when it led to the same goal.
std::uint32_t Planner::Search::expected_cost() const {
  constexpr int kDetour = 40;  // cells
  if (!last_ || last_->goal != query_.goal) return 0;
  return last_->cost + last_->cost / 16 + kDetour * costs_.least[0];
}

/// Brings what is known of the floor up to date.
void Planner::Search::survey(const FloorMap& map, const GroundView& ground) {
  if (floor_.update(map, ground) || !search_) search_.emplace(floor_.chunks(), costs_);
}

PlanResult Planner::Search::search(const FloorMap& map, const Pose2& start, const End& end,
                                   unsigned headings) {
  query_.start = map.grid.cell(start.position());
  query_.goal = map.grid.cell(end.position);
  auto found = search_->run(query_, config_.budget, expected_cost());
  if (!found) {
    last_.reset();
    return explain_no_path(map.grid, end.position, headings);
  }
  last_ = {query_.goal, found->cost};
  PlanResult result;
  result.bound = found->bound;
  result.first_expansions = found->first_relaxed;
  result.expansions = found->relaxed;
  result.path = path_of(std::move(*found), start, end);
  return result;
}

PlanResult Planner::Search::explain_no_path(const FloorGrid& grid, const Vector2d& goal, unsigned headings) {
  PlanResult result;
  result.first_expansions = result.expansions = search_->to_goal().relaxed();
  const std::vector<std::uint8_t> reached = reachable_headings(floor_.chunks(), query_.start, headings);
  double least = 0;
  std::size_t cells = 0;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (reached[grid.index({x, y})] == 0) continue;
      const double distance = (grid.centre({x, y}) - goal).norm();
      if (cells++ > 0 && distance >= least) continue;
      least = distance;
      result.nearest = grid.centre({x, y});
    }
  }
  result.reason = cells > 1 ? NoPath::kEnclosed : NoPath::kStartBlocked;
  if (cells <= 1) result.nearest.reset();
  for (int h = 0; h < kHeadings; ++h) {
    const bool arrives = reached[grid.index(query_.goal)] >> h & 1;
    if (arrives && query_.arrival_cost[static_cast<std::size_t>(h)] != kTooDear)
      result.reason = NoPath::kTooFar;
  }
  return result;
}

Path Planner::Search::path_of(PathSearch::Found found, const Pose2& start, const End& end) const {
  Path path;
  path.start = start;
  path.states = std::move(found.states);
  for (const std::uint32_t cost : found.cost_so_far) path.cost_so_far_s.push_back(cost * costs_.tick);
  path.end = end.position;
  path.end_yaw = end.yaw;
  path.cost = shares(path);
  path.cost_s = found.cost * costs_.tick;
  return path;
}

PathCost Planner::Search::shares(const Path& path) const {
  std::uint32_t walking = 0, turning = 0, modes = 0, nearness = 0, unseen = 0;
  turning += turn_cost(wrap_angle(heading_angle(path.states.front().heading) - path.start.yaw));
  for (std::size_t i = 1; i < path.states.size(); ++i) {
    const auto motion = motion_between(path.states[i - 1], path.states[i]);
    if (!motion) {
      modes += costs_.mode_change;
      continue;
    }
    const Vector2i& from = path.states[i - 1].cell;
    const bool diagonal = motion->direction() % 2 != 0;
    const Ticks of_unseen = floor_.prices().unseen(floor_.raster(), from.x(), from.y(), diagonal);
    walking += costs_.walking(*motion);
    turning += static_cast<std::uint32_t>(costs_.of(*motion) - costs_.walking(*motion));
    nearness += static_cast<std::uint32_t>(floor_.chunks().price(from.x(), from.y(), diagonal) - of_unseen);
    unseen += of_unseen;
  }
  if (path.end_yaw)
    turning += turn_cost(wrap_angle(*path.end_yaw - heading_angle(path.states.back().heading)));
  const double t = costs_.tick;
  return {walking * t, turning * t, modes * t, nearness * t, unseen * t};
}

PlanResult Planner::Search::plan(const FloorMap& map, const Pose2& start, const Goal& goal) {
  const GroundView ground = view(map, start);
  PlanResult result = plan_to(map, ground, start, goal);
  const bool no_way = result.reason == NoPath::kGoalBlocked || result.reason == NoPath::kGoalOutside ||
                      result.reason == NoPath::kEnclosed;
  if (!goal.near || !no_way) return result;
  survey(map, ground);
  const std::optional<End> end = nearest_end(ground, start, goal);
  if (!end) return result;
  PlanResult near = go(map, ground, start, *end);
  near.short_of_goal = result.reason;
  return near;
}

PlanResult Planner::Search::plan_to(const FloorMap& map, const GroundView& ground, const Pose2& start,
                                    const Goal& goal) {
  const auto no = [](NoPath reason) {
    PlanResult result;
    result.reason = reason;
    return result;
  };
  const FloorGrid& grid = map.grid;
  if (!grid.contains(grid.cell(start.position()))) return no(NoPath::kStartBlocked);
  if (!grid.contains(grid.cell(goal.position))) return no(NoPath::kGoalOutside);
  const std::optional<End> end = choose_end(ground, goal);
  return end ? go(map, ground, start, *end) : no(NoPath::kGoalBlocked);
}

/// To an end that can_end() was asked about last.
PlanResult Planner::Search::go(const FloorMap& map, const GroundView& ground, const Pose2& start,
                               const End& end) {
  PlanResult result;
  if (stays(ground, start, end)) {
    result.path = stay(map.grid, start, end);
    return result;
  }
  const unsigned headings = list_starts(ground, start);
  if (headings == 0) {
    result.reason = NoPath::kStartBlocked;
    return result;
  }
  survey(map, ground);
  result = search(map, start, end, headings);
  if (result.reason != NoPath::kTooFar || config_.ticks_per_cell == 1) return result;
  if (!coarser_) {
    PlannerConfig coarser = config_;
    coarser.ticks_per_cell /= 2;
    coarser_ = std::make_unique<Search>(coarser, gait_, outline_, resolution_);
  }
  return coarser_->plan(map, start, {end.position, end.yaw});
}

void Planner::Search::forget() {
  floor_.forget();
  last_.reset();
  coarser_.reset();
}

Planner::Planner(const PlannerConfig& config, const GaitLimits& gait, const BodyOutline& outline,
                 const FloorGrid& grid) {
  config.validate();
  gait.validate();
  outline.validate();
  search_ = std::make_unique<Search>(config, gait, outline, grid.resolution);
}
Planner::~Planner() = default;
Planner::Planner(Planner&&) noexcept = default;
Planner& Planner::operator=(Planner&&) noexcept = default;

PlanResult Planner::plan(const FloorMap& map, const Pose2& start, const Goal& goal) {
  return search_->plan(map, start, goal);
}

const Masks& Planner::masks() const { return search_->masks(); }
double Planner::tick() const { return search_->tick(); }
std::size_t Planner::bytes() const { return search_->bytes(); }
void Planner::forget() { search_->forget(); }

}  // namespace headway::nav
