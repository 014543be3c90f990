// Which of the planned steps may be committed: only those onto floor that has been seen, and seen recently.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "nav/body_outline.h"
#include "nav/floor_map.h"
#include "nav/footsteps.h"
#include "nav/walking/gait.h"

namespace headway::runtime {

struct FloorGateConfig {
  Duration recent = seconds(10);  ///< how long a look at the floor is good for
  /// Around where the robot is now [m]: the head cannot look at floor this near, so there a look never grows
  /// old, and what the body (not the sole) is over need not have been seen.
  double blind_radius = 0.70;
};

/// How far the way is open.
struct Gate {
  std::size_t open = 0;  ///< steps, from the first asked for, that may be committed
  bool blocked = false;  ///< what closes it is an obstacle, not missing sight
  std::vector<Eigen::Vector2i>
      missing;  ///< cells that hold up the first closed step; empty when all are open
};

/// Looks at steps `from`, `from` + 1, ... of a walk until one may not be committed.
class FloorGate {
 public:
  FloorGate(const FloorGateConfig& config, const nav::GaitLimits& gait, const nav::BodyOutline& outline)
      : config_(config), gait_(gait), outline_(outline) {}

  /// `robot_now`: where the robot is, not where the committed steps will take it. Floor that is known only
  /// from before (free, and never seen) counts as unseen.
  Gate check(const nav::Walk& walk, std::size_t from, const nav::FloorMap& floor, const Pose2& robot_now,
             Time now) const;
  /// How many steps of the rest of a walk the body makes before it comes too near to an obstacle, or a foot
  /// treads on something, or does not go high over it.
  std::size_t clear_steps(const nav::Walk& walk, std::size_t from, const nav::FloorMap& floor) const;
  /// Whether it meets none anywhere along it.
  bool clear(const nav::Walk& walk, std::size_t from, const nav::FloorMap& floor) const;
  /// Whether the body alone would meet an obstacle at one of these bases.
  bool hits(std::span<const Pose2> bases, const nav::FloorMap& floor) const;

 private:
  void check_step(const nav::Walk& walk, std::size_t step, const nav::FloorMap& floor, const Pose2& robot_now,
                  Time now, Gate& gate) const;
  bool trips(const nav::Walk& walk, std::size_t step, const nav::FloorMap& floor) const;

  FloorGateConfig config_;
  nav::GaitLimits gait_;
  nav::BodyOutline outline_;
};

}  // namespace headway::runtime
