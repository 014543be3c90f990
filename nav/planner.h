// A* over (cell, heading, mode): the cheapest walk, in seconds, that takes the body past every obstacle.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "nav/body_outline.h"
#include "nav/floor_map.h"
#include "nav/gait.h"
#include "nav/ground.h"
#include "nav/masks.h"

namespace headway::nav {

struct PlannerConfig {
  UnseenFloor unseen = UnseenFloor::kCostly;
  double unseen_price = 2.0;  ///< walking time added on unseen floor, as a share of walking straight over it
  double corridor = 0.15;     ///< half side of the square around the base whose unseen share is priced [m]
  double near_price = 1.0;    ///< walking time added right beside an obstacle, same unit
  double near_range = 0.70;   ///< where that price has fallen to nothing, from the base [m]
  double turn_price = 1.0;    ///< weight of the time that turns take
  double mode_change = 1.6;   ///< from forward to sideway or back [s]
  bool start_is_free = true;  ///< the body's own place at the start counts as free, whatever the map says

  /// Throws InputError `planner: key: what, expected what`.
  void validate() const;
};

/// The robot stands on the centre of a cell and faces 45 deg * heading.
struct PathState {
  Eigen::Vector2i cell{0, 0};
  int heading = 0;
  Mode mode = Mode::kForward;
  bool operator==(const PathState&) const = default;
};

struct Goal {
  Eigen::Vector2d position{0, 0};  ///< map frame [m]
  std::optional<double> yaw;       ///< [rad]; nothing: as it arrives
  double tolerance = 0.10;  ///< where the body does not fit the position, a place this near will do [m]
};

/// Seconds of walking, by what they are spent on.
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
  kEnclosed,      ///< obstacles between start and goal; see `nearest`
};
const char* describe(NoPath reason);

struct PlanResult {
  NoPath reason = NoPath::kNone;
  Path path;                               ///< empty unless reason is kNone
  std::optional<Eigen::Vector2d> nearest;  ///< kEnclosed: the reachable cell centre nearest to the goal [m]
  std::size_t expansions = 0;              ///< states taken from the open list

  explicit operator bool() const { return reason == NoPath::kNone; }
};

/// Keeps its buffers between plans: after the first on a map of some size it allocates only the result.
/// The same inputs give the same path, whatever was planned before.
class Planner {
 public:
  /// The masks are made for the grid's resolution. Throws InputError on bad configuration.
  Planner(const PlannerConfig& config, const GaitLimits& gait, const BodyOutline& outline,
          const FloorGrid& grid);
  ~Planner();
  Planner(Planner&&) noexcept;
  Planner& operator=(Planner&&) noexcept;

  /// The cheapest path from a base pose at rest or while walking. Floor outside the map is blocked.
  /// Cost of one motion, each term rounded to a millisecond: its walking and turning time by the gait, plus,
  /// for the cell it reaches, near_price * max(0, 1 - d / near_range) and unseen_price * share times the time
  /// to walk its length straight on (d: centre to the centre of the nearest blocked cell).
  PlanResult plan(const FloorMap& map, const Pose2& start, const Goal& goal);

  /// Whether a path's motions from state `from` on are still free on another map of the same grid.
  bool still_valid(const Path& path, const FloorMap& map, std::size_t from = 0) const;

  const Masks& masks() const;

 private:
  class Search;
  std::unique_ptr<Search> search_;
};

}  // namespace headway::nav
