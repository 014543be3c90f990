// How far the body can turn on the spot before it meets something.
#pragma once

#include <vector>

#include "nav/body_outline.h"
#include "nav/ground.h"

namespace headway::nav {

class TurnRoom {
 public:
  /// What stands near a place on the floor.
  TurnRoom(const GroundView& ground, const BodyOutline& outline, const Eigen::Vector2d& place);

  bool fits(double yaw) const { return free(yaw, 0); }
  /// Whether the body can turn from one yaw to another, the shorter way.
  bool can_turn(double from, double to) const;

 private:
  static constexpr double kSlack = 0.01;
  struct Obstacle {
    Eigen::Vector2d centre;
    double clearance;
  };
  bool free(double yaw, double widened) const;

  BodyOutline outline_;
  Eigen::Vector2d place_;
  double size_;
  std::vector<Obstacle> obstacles_;
};

}  // namespace headway::nav
