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

namespace {

/// The goal's own position, and the middles of all cells within its tolerance, the nearest first.
std::vector<Vector2d> places_near(const FloorGrid& grid, const Goal& goal) {
  const Vector2i own = grid.cell(goal.position);
  const int around = static_cast<int>(goal.tolerance / grid.resolution) + 1;
  std::vector<std::pair<double, Vector2d>> others;
  for (int y = own.y() - around; y <= own.y() + around; ++y) {
    for (int x = own.x() - around; x <= own.x() + around; ++x) {
      const double distance = (grid.centre({x, y}) - goal.position).norm();
      if (grid.contains({x, y}) && distance <= goal.tolerance)
        others.emplace_back(distance, grid.centre({x, y}));
    }
  }
  std::stable_sort(others.begin(), others.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vector2d> places{goal.position};
  for (const auto& other : others) places.push_back(other.second);
  return places;
}

/// Whether the body can turn to a yaw from one of these headings.
bool turns_to(const TurnRoom& room, unsigned headings, double yaw) {
  for (int h = 0; h < kHeadings; ++h)
    if ((headings >> h & 1) && room.can_turn(heading_angle(h), yaw)) return true;
  return false;
}

}  // namespace

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
  void choose_ends(const GroundView& ground, const Goal& goal);
  std::optional<End> choose_nearest_end(const GroundView& ground, const Pose2& start, const Goal& goal);
  unsigned standing_headings(const GroundView& ground, const Vector2i& cell) const;
  Arrival arrival_at(const Vector2i& cell, const TurnRoom& room, unsigned standing,
                     std::optional<double> yaw) const;
  PlanResult plan_to(const FloorMap& map, const GroundView& ground, const Pose2& start, const Goal& goal);
  PlanResult go(const FloorMap& map, const GroundView& ground, const Pose2& start, const Goal& goal);
  void survey(const FloorMap& map, const GroundView& ground);
  bool stays(const GroundView& ground, const Pose2& start, const End& end) const;
  Path stay(const FloorGrid& grid, const Pose2& start, const End& end) const;
  unsigned list_starts(const GroundView& ground, const Pose2& start);
  PlanResult search(const FloorMap& map, const Pose2& start, unsigned headings);
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
  std::vector<End> ends_;  ///< of the query's goals
  struct Last {
    Vector2i goal;
    std::uint32_t cost;
  };
  std::optional<Last> last_;
  std::unique_ptr<Search> coarser_;  ///< for walks so long that costs do not fit
};

/// The headings in which the body stands free there, a bit each.
unsigned Planner::Search::standing_headings(const GroundView& ground, const Vector2i& cell) const {
  unsigned headings = 0;
  for (int h = 0; h < kHeadings; ++h)
    headings |= static_cast<unsigned>(!ground.blocks(cell, masks_.standing(h), bare_masks_.standing(h)) &&
                                      !ground.any_low(cell, masks_.standing(h)))
                << h;
  return headings;
}

/// What the last turn costs from each heading.
Arrival Planner::Search::arrival_at(const Vector2i& cell, const TurnRoom& room, unsigned standing,
                                    std::optional<double> yaw) const {
  Arrival arrival{cell, {}};
  for (int h = 0; h < kHeadings; ++h) {
    const double heading = heading_angle(h);
    const bool can = (standing >> h & 1) && (!yaw || room.can_turn(heading, *yaw));
    const Ticks turn = yaw ? turn_cost(wrap_angle(*yaw - heading)) : Ticks{0};
    arrival.cost[static_cast<std::size_t>(h)] = can ? turn : kTooDear;
  }
  return arrival;
}

/// The place nearest to the goal where the body can come to rest with the goal's yaw. Without one, the
/// nearest where it stands at all, and those that each of the eight headings would get: any heading will do
/// at each, so that to leave the yaw open never costs more than to say it.
void Planner::Search::choose_ends(const GroundView& ground, const Goal& goal) {
  ends_.clear();
  query_.goals.clear();
  std::vector<double> wanted;
  if (goal.yaw) wanted.push_back(*goal.yaw);
  for (int h = 0; h < kHeadings && !goal.yaw; ++h) wanted.push_back(heading_angle(h));
  for (const Vector2d& place : places_near(ground.grid(), goal)) {
    const Vector2i cell = ground.grid().cell(place);
    const unsigned standing = standing_headings(ground, cell);
    if (standing == 0) continue;
    const TurnRoom room(ground, outline_, place);
    const auto rests = [&](double yaw) { return room.fits(yaw) && turns_to(room, standing, yaw); };
    const bool serves = std::erase_if(wanted, rests) > 0 || (!goal.yaw && ends_.empty());
    const bool known = std::ranges::find(query_.goals, cell, &Arrival::cell) != query_.goals.end();
    if (serves && !known) {
      ends_.push_back({place, goal.yaw});
      query_.goals.push_back(arrival_at(cell, room, standing, goal.yaw));
    }
    if (wanted.empty()) return;
  }
}

/// The middle of the reachable cell nearest to the goal where the robot can come to rest, facing as wished;
/// of equally near ones the first in the map.
std::optional<Planner::Search::End> Planner::Search::choose_nearest_end(const GroundView& ground,
                                                                        const Pose2& start,
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
    const TurnRoom room(ground, outline_, grid.centre(cell));
    const Arrival arrival = arrival_at(cell, room, standing_headings(ground, cell), goal.yaw);
    for (int h = 0; h < kHeadings; ++h) {
      if (!(reached[i] >> h & 1) || arrival.cost[static_cast<std::size_t>(h)] == kTooDear) continue;
      ends_ = {{grid.centre(cell), goal.yaw}};
      query_.goals = {arrival};
      return ends_.front();
    }
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
  if (!last_ || last_->goal != query_.goals.front().cell) return 0;
  return last_->cost + last_->cost / 16 + kDetour * costs_.least[0];
}

/// Brings what is known of the floor up to date.
void Planner::Search::survey(const FloorMap& map, const GroundView& ground) {
  const FloorChanges& changes = floor_.update(map, ground);
  if (!search_ || !search_->to_goal().fits(floor_.chunks()))
    search_.emplace(floor_.chunks(), costs_);
  else
    search_->floor_changed(changes);
}

PlanResult Planner::Search::search(const FloorMap& map, const Pose2& start, unsigned headings) {
  query_.start = map.grid.cell(start.position());
  auto found = search_->run(query_, config_.budget, expected_cost());
  if (!found) {
    last_.reset();
    return explain_no_path(map.grid, ends_.front().position, headings);
  }
  last_ = {query_.goals.front().cell, found->cost};
  PlanResult result;
  result.bound = found->bound;
  result.first_expansions = found->first_relaxed;
  result.expansions = found->relaxed;
  const auto goal = std::ranges::find(query_.goals, found->states.back().cell, &Arrival::cell);
  const End& end = ends_[static_cast<std::size_t>(goal - query_.goals.begin())];
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
  for (const Arrival& end : query_.goals) {
    for (int h = 0; h < kHeadings; ++h) {
      const bool arrives = reached[grid.index(end.cell)] >> h & 1;
      if (arrives && end.cost[static_cast<std::size_t>(h)] != kTooDear) result.reason = NoPath::kTooFar;
    }
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
    const bool over = floor_.raster().row(from.y())[from.x()] == Ground::kLow;
    const Ticks of_low = over ? floor_.prices().low() : Ticks{0};
    walking += std::uint32_t{costs_.walking(*motion)} + of_low;
    turning += static_cast<std::uint32_t>(costs_.of(*motion) - costs_.walking(*motion));
    nearness +=
        static_cast<std::uint32_t>(floor_.chunks().price(from.x(), from.y(), diagonal) - of_unseen - of_low);
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
  const std::optional<End> end = choose_nearest_end(ground, start, goal);
  if (!end) return result;
  PlanResult near = go(map, ground, start, {end->position, end->yaw});
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
  choose_ends(ground, goal);
  return ends_.empty() ? no(NoPath::kGoalBlocked) : go(map, ground, start, goal);
}

/// To the cheapest of the ends that were chosen for the goal.
PlanResult Planner::Search::go(const FloorMap& map, const GroundView& ground, const Pose2& start,
                               const Goal& goal) {
  PlanResult result;
  for (const End& end : ends_) {
    if (!stays(ground, start, end)) continue;
    result.path = stay(map.grid, start, end);
    return result;
  }
  const unsigned headings = list_starts(ground, start);
  if (headings == 0) {
    result.reason = NoPath::kStartBlocked;
    return result;
  }
  survey(map, ground);
  result = search(map, start, headings);
  if (result.reason != NoPath::kTooFar || config_.ticks_per_cell == 1) return result;
  if (!coarser_) {
    PlannerConfig coarser = config_;
    coarser.ticks_per_cell /= 2;
    coarser_ = std::make_unique<Search>(coarser, gait_, outline_, resolution_);
  }
  return coarser_->plan(map, start, {goal.position, goal.yaw, goal.tolerance});
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
