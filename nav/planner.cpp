#include "nav/planner.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "hal/error.h"
#include "nav/path_search.h"
#include "nav/turn_room.h"

namespace headway::nav {

namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

void expect(bool good, const std::string& key, double value, const std::string& expected) {
  if (!good) throw InputError("planner: " + key + ": is " + std::to_string(value) + ", expected " + expected);
}

/// The motion from one state of a path to the next; nothing when only the mode changes.
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
    case NoPath::kEnclosed:
      return "obstacles close every way to the goal";
  }
  return "";
}

void PlannerConfig::validate() const {
  const auto within = [](double v, double lowest, double highest, const char* key, const char* unit = "") {
    expect(v >= lowest && v <= highest, key, v,
           std::to_string(lowest) + " to " + std::to_string(highest) + unit);
  };
  within(unseen_price, 0, 100, "unseen_price");
  within(corridor, 0, 1, "corridor", " m");
  within(near_price, 0, 100, "near_price");
  within(near_range, 0, 3, "near_range", " m");
  within(turn_price, 0, 100, "turn_price");
  within(mode_change, 0, 100, "mode_change", " s");
}

class Planner::Search {
 public:
  Search(const PlannerConfig& config, const GaitLimits& gait, const BodyOutline& outline, double resolution)
      : config_(config),
        gait_(gait),
        outline_(outline),
        masks_(outline, resolution),
        bare_masks_(outline.bare(), resolution),
        dilation_(masks_),
        bare_dilation_(bare_masks_),
        costs_(config, gait, resolution),
        prices_(config, gait, resolution) {}
  // The search refers to its siblings.
  Search(const Search&) = delete;
  Search& operator=(const Search&) = delete;

  PlanResult plan(const FloorMap& map, const Pose2& start, const Goal& goal);
  bool still_valid(const Path& path, const FloorMap& map, std::size_t from) const;
  const Masks& masks() const { return masks_; }

 private:
  struct End {
    Vector2d position;
    std::optional<double> yaw;
  };

  GroundView view(const FloorMap& map, const Pose2& start) const {
    return {map, config_.unseen, outline_, start, config_.start_is_free};
  }
  std::uint32_t turn_cost(double angle) const {
    return milliseconds(config_.turn_price * gait_.turn_seconds(angle));
  }
  bool stands(const GroundView& ground, const Vector2i& cell, int heading) const;
  std::optional<End> choose_end(const GroundView& ground, const Goal& goal);
  bool can_end(const GroundView& ground, const Vector2i& cell, const End& end);
  bool stays(const GroundView& ground, const Pose2& start, const End& end) const;
  Path stay(const FloorGrid& grid, const Pose2& start, const End& end) const;
  void list_starts(const GroundView& ground, const Pose2& start);
  void survey(const GroundView& ground);
  PlanResult explain_no_path(const FloorGrid& grid, const Vector2d& goal);
  Path path_of(const PathSearch::Found& found, const Pose2& start, const End& end) const;
  PathCost shares(const Path& path) const;

  PlannerConfig config_;
  GaitLimits gait_;
  BodyOutline outline_;
  Masks masks_, bare_masks_;
  MaskDilation dilation_, bare_dilation_;
  MotionCosts costs_;
  BlockedMotions blocked_;
  FloorPrices prices_;
  PathSearch search_{costs_, blocked_, prices_};

  std::vector<Ground> ground_;
  CellBits bits_;
  PathSearch::Problem problem_;
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
    const std::uint32_t turn = end.yaw ? turn_cost(wrap_angle(*end.yaw - heading)) : 0;
    problem_.arrival_cost[static_cast<std::size_t>(h)] = can ? turn : kUnreachable;
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
  path.cost.turning = turn_cost(wrap_angle(yaw - start.yaw)) * 1e-3;
  path.cost_s = path.cost.total();
  path.end = end.position;
  path.end_yaw = end.yaw;
  return path;
}

/// The headings to which the robot can turn where it stands.
void Planner::Search::list_starts(const GroundView& ground, const Pose2& start) {
  problem_.starts.clear();
  const TurnRoom room(ground, outline_, start.position());
  for (int h = 0; h < kHeadings; ++h) {
    if (!room.can_turn(start.yaw, heading_angle(h))) continue;
    problem_.starts.push_back({h, turn_cost(wrap_angle(heading_angle(h) - start.yaw))});
  }
}

/// Everything the search reads of the floor.
void Planner::Search::survey(const GroundView& ground) {
  const FloorGrid& grid = ground.grid();
  ground.survey(ground_);
  prices_.compute(grid.width, grid.height, ground_);
  blocked_.reset(grid.width, grid.height);
  int tight_from = grid.height, tight_to = -1;
  bits_.reset(grid.width, grid.height, true);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const Ground g = ground_[grid.index({x, y})];
      if (g == Ground::kBlocked) bits_.set(x, y);
      if (g != Ground::kTight) continue;
      tight_from = std::min(tight_from, y);
      tight_to = y;
    }
  }
  dilation_.block(bits_, 0, grid.height - 1, blocked_);
  if (tight_to < 0) return;
  bits_.reset(grid.width, grid.height, false);
  for (int y = tight_from; y <= tight_to; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (ground_[grid.index({x, y})] == Ground::kTight) bits_.set(x, y);
    }
  }
  bare_dilation_.block(bits_, std::max(0, tight_from - bare_dilation_.highest()),
                       std::min(grid.height - 1, tight_to - bare_dilation_.lowest()), blocked_);
}

PlanResult Planner::Search::explain_no_path(const FloorGrid& grid, const Vector2d& goal) {
  PlanResult result;
  result.expansions = search_.expansions();
  const std::vector<std::uint8_t>& reached = search_.flood(problem_);
  double least = 0;
  std::size_t cells = 0;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (!reached[grid.index({x, y})]) continue;
      const double distance = (grid.centre({x, y}) - goal).norm();
      if (cells++ > 0 && distance >= least) continue;
      least = distance;
      result.nearest = grid.centre({x, y});
    }
  }
  result.reason = cells > 1 ? NoPath::kEnclosed : NoPath::kStartBlocked;
  if (cells <= 1) result.nearest.reset();
  return result;
}

Path Planner::Search::path_of(const PathSearch::Found& found, const Pose2& start, const End& end) const {
  Path path;
  path.start = start;
  for (std::size_t i = 0; i < found.states.size(); ++i) {
    const auto state = static_cast<int>(found.states[i]);
    const int cell = state / kLayers, layer = state % kLayers;
    path.states.push_back({{cell % problem_.width, cell / problem_.width},
                           layer % kHeadings,
                           layer < kHeadings ? Mode::kForward : Mode::kSideway});
    path.cost_so_far_s.push_back(found.cost_so_far[i] * 1e-3);
  }
  path.end = end.position;
  path.end_yaw = end.yaw;
  path.cost = shares(path);
  path.cost_s = found.cost * 1e-3;
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
    const auto c = static_cast<std::size_t>(motion->configuration());
    const Vector2i& to = path.states[i].cell;
    const std::size_t cell = static_cast<std::size_t>(to.y()) * static_cast<std::size_t>(problem_.width) +
                             static_cast<std::size_t>(to.x());
    const bool diagonal = motion->direction() % 2 != 0;
    walking += costs_.walking[c];
    turning += costs_.turning[c];
    nearness += prices_.near(cell, diagonal);
    unseen += prices_.unseen(cell, diagonal);
  }
  if (path.end_yaw)
    turning += turn_cost(wrap_angle(*path.end_yaw - heading_angle(path.states.back().heading)));
  return {walking * 1e-3, turning * 1e-3, modes * 1e-3, nearness * 1e-3, unseen * 1e-3};
}

PlanResult Planner::Search::plan(const FloorMap& map, const Pose2& start, const Goal& goal) {
  const auto no = [](NoPath reason) {
    PlanResult result;
    result.reason = reason;
    return result;
  };
  const FloorGrid& grid = map.grid;
  if (!grid.contains(grid.cell(goal.position))) return no(NoPath::kGoalOutside);
  if (!grid.contains(grid.cell(start.position()))) return no(NoPath::kStartBlocked);
  const GroundView ground = view(map, start);
  const std::optional<End> end = choose_end(ground, goal);
  if (!end) return no(NoPath::kGoalBlocked);
  PlanResult result;
  if (stays(ground, start, *end)) {
    result.path = stay(grid, start, *end);
    return result;
  }
  list_starts(ground, start);
  if (problem_.starts.empty()) return no(NoPath::kStartBlocked);
  survey(ground);
  problem_.width = grid.width;
  problem_.height = grid.height;
  problem_.start = grid.index(grid.cell(start.position()));
  problem_.goal = grid.index(grid.cell(end->position));
  const auto found = search_.run(problem_);
  if (!found) return explain_no_path(grid, end->position);
  result.expansions = search_.expansions();
  result.path = path_of(*found, start, *end);
  return result;
}

bool Planner::Search::still_valid(const Path& path, const FloorMap& map, std::size_t from) const {
  if (path.states.empty()) return false;
  const GroundView ground = view(map, path.start);
  const auto turns = [&](const Vector2d& place, double a, double b) {
    return TurnRoom(ground, outline_, place).can_turn(a, b);
  };
  const bool moves = path.states.size() > 1;
  if (!moves) return !path.end_yaw || turns(path.start.position(), path.start.yaw, *path.end_yaw);
  const double first = heading_angle(path.states.front().heading);
  if (from == 0 && !turns(path.start.position(), path.start.yaw, first)) return false;
  for (std::size_t i = from + 1; i < path.states.size(); ++i) {
    const auto motion = motion_between(path.states[i - 1], path.states[i]);
    if (!motion) continue;
    if (ground.blocks(path.states[i - 1].cell, masks_.of(*motion), bare_masks_.of(*motion))) return false;
  }
  return !path.end_yaw || turns(path.end, heading_angle(path.states.back().heading), *path.end_yaw);
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

bool Planner::still_valid(const Path& path, const FloorMap& map, std::size_t from) const {
  return search_->still_valid(path, map, from);
}

const Masks& Planner::masks() const { return search_->masks(); }

}  // namespace headway::nav
