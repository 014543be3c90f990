// The floor map as the planner takes it, from where the robot stands.
#pragma once

#include <cstdint>

#include "nav/body_outline.h"
#include "nav/floor_map.h"
#include "nav/masks.h"

namespace headway::nav {

/// How the planner takes a cell.
enum class Ground : std::uint8_t {
  kFree,
  kUnseen,  ///< free, at a price
  kLow,     ///< the body may pass over it, straight on and at a price; no foot may be put there
  kTight,   ///< blocked, but so near the start that only the bare body must keep off it
  kBlocked,
};
inline bool is_obstacle(Ground g) { return g >= Ground::kTight; }

/// What the planner makes of floor that nobody has seen.
enum class UnseenFloor : std::uint8_t { kBlocked, kCostly, kFree };

/// Wherever the start does not matter.
inline Ground ground_of(Floor floor, UnseenFloor unseen) {
  if (floor == Floor::kBlocked) return Ground::kBlocked;
  if (floor == Floor::kLow) return Ground::kLow;
  if (floor == Floor::kFree || unseen == UnseenFloor::kFree) return Ground::kFree;
  return unseen == UnseenFloor::kBlocked ? Ground::kBlocked : Ground::kUnseen;
}

/// Cells from `low` to `high`, both inclusive.
struct CellBox {
  Eigen::Vector2i low{0, 0}, high{-1, -1};
};

/// Outside the map everything is blocked. Where the body stands at the start is free, if so configured:
/// nothing else can be there. And what came within its clearance before it noticed must not nail it to the
/// spot.
class GroundView {
 public:
  GroundView(const FloorMap& map, UnseenFloor unseen, const BodyOutline& outline, const Pose2& start,
             bool start_is_free)
      : map_(map), unseen_(unseen), outline_(outline), start_(start), start_is_free_(start_is_free) {}

  const FloorGrid& grid() const { return map_.grid; }
  Ground at(const Eigen::Vector2i& cell) const;
  /// Where the start may make a cell another than the map alone; within the grid.
  CellBox near_start() const;
  /// Whether a mask around `cell` meets an obstacle, or the bare body's mask a kTight one.
  bool blocks(const Eigen::Vector2i& cell, const Mask& mask, const Mask& bare_mask) const;
  /// Whether a mask around `cell` meets a kLow one.
  bool any_low(const Eigen::Vector2i& cell, const Mask& mask) const;

 private:
  Ground on_the_map(const Eigen::Vector2i& cell) const;
  Ground as_seen_from_start(const Eigen::Vector2i& cell, Ground on_map) const;
  double near_start_reach() const;

  const FloorMap& map_;
  UnseenFloor unseen_;
  BodyOutline outline_;
  Pose2 start_;
  bool start_is_free_;
};

}  // namespace headway::nav
