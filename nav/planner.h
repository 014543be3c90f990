// The cheapest walk over (cell, heading, mode), in seconds, that takes the body past every obstacle.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/body_outline.h"
#include "nav/floor_map.h"
#include "nav/ground.h"
#include "nav/masks.h"
#include "nav/path_search.h"
#include "nav/planner_config.h"
#include "nav/walking/gait.h"

namespace headway::nav {

struct Goal {
  Eigen::Vector2d position{0, 0};  ///< map frame [m]
  std::optional<double> yaw;       ///< [rad]; nothing: as it arrives, never dearer than with one of the eight
  double tolerance = 0.10;  ///< where the body does not fit the position, a place this near will do [m]
  /// Where no way leads there: the reachable place nearest to it will do, measured straight over the floor
  /// from the position to the centre of the cell under the base.
  bool near = false;
};

/// Seconds of walking, by what they are spent on; stepping over what is low counts as walking.
struct PathCost {
  double walking = 0, turning = 0, mode_changes = 0, nearness = 0, unseen = 0;
  double total() const { return walking + turning + mode_changes + nearness + unseen; }
};

struct Path {
  Pose2 start;                        ///< as given: the first state's cell lies under it
  std::vector<PathState> states;      ///< neighbours differ by one motion, or by the mode alone
  std::vector<double> cost_so_far_s;  ///< at each state; the first has the turn to its heading [s]
  PathCost cost;
  double cost_s = 0;              ///< total, with the turn at the goal [s]
  Eigen::Vector2d end{0, 0};      ///< the goal's position, or the near-by one taken for it [m]
  std::optional<double> end_yaw;  ///< the goal's [rad]
};

enum class NoPath : std::uint8_t {
  kNone,          ///< there is one
  kStartBlocked,  ///< outside the map, or no motion is possible
  kGoalBlocked,   ///< the body does not fit there
  kGoalOutside,   ///< the goal is not on the map
  kTooFar,        ///< there is a way, but a longer one than can be counted
  kEnclosed,      ///< obstacles between start and goal; see `nearest`
};
const char* describe(NoPath reason);

struct PlanResult {
  NoPath reason = NoPath::kNone;
  Path path;                               ///< empty unless reason is kNone
  NoPath short_of_goal = NoPath::kNone;    ///< why the path leads only as near as it gets (Goal::near)
  std::optional<Eigen::Vector2d> nearest;  ///< kEnclosed: the reachable cell centre nearest to the goal [m]
  double bound = 1;                        ///< no path costs less than the found one's cost / bound
  /// Work done, in chunks of 16 cells and all their states: until a path was known, and in all.
  std::size_t first_expansions = 0, expansions = 0;

  explicit operator bool() const { return reason == NoPath::kNone; }
};

/// For people: how near a path comes that falls short of the goal, and why; empty for any other.
std::string describe_shortfall(const PlanResult& result, const Goal& goal);

/// Keeps its buffers and what it made of the last map: of the next one only the changed cells are worked on.
/// Where the optimum is found (bound 1), the same inputs give the same path, whatever was planned before.
class Planner {
 public:
  /// The masks are made for the grid's resolution. Throws InputError on bad configuration.
  Planner(const PlannerConfig& config, const GaitLimits& gait, const BodyOutline& outline,
          const FloorGrid& grid);
  ~Planner();
  Planner(Planner&&) noexcept;
  Planner& operator=(Planner&&) noexcept;

  /// A path from a base pose at rest or while walking: first within 1.0625 of the cheapest, then bettered
  /// towards it within the configured budget. Floor outside the map is blocked. Cost of one motion, each term
  /// rounded to a tick: its walking and turning time by the gait, plus, for the cell it leaves, near_price *
  /// max(0, 1 - d / near_range) and unseen_price * share times the time to walk its length straight on (d:
  /// centre to the centre of the nearest blocked cell), and gait.over.cost where it is low.
  PlanResult plan(const FloorMap& map, const Pose2& start, const Goal& goal);

  const Masks& masks() const;
  double tick() const;        ///< the unit of all costs [s]
  std::size_t bytes() const;  ///< of memory that grows with the map

  /// The next map counts as the first one: what was made of the last is forgotten.
  void forget();

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

}  // namespace headway::nav
