#include "nav/turn_room.h"

#include <algorithm>
#include <cmath>

namespace headway::nav {

TurnRoom::TurnRoom(const GroundView& ground, const BodyOutline& outline, const Eigen::Vector2d& place)
    : outline_(outline), place_(place), size_(ground.grid().resolution) {
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(outline.reach() + kSlack);
  const Eigen::Vector2i low = ground.grid().cell(place - reach), high = ground.grid().cell(place + reach);
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      const Ground g = ground.at({x, y});
      if (!is_obstacle(g)) continue;
      obstacles_.push_back({ground.grid().centre({x, y}), g == Ground::kTight ? 0 : outline.clearance()});
    }
  }
}

bool TurnRoom::free(double yaw, double widened) const {
  const Pose2 base{place_.x(), place_.y(), yaw};
  return std::none_of(obstacles_.begin(), obstacles_.end(), [&](const Obstacle& o) {
    return distance_to_square(outline_, base, o.centre, size_) <= o.clearance + widened;
  });
}

bool TurnRoom::can_turn(double from, double to) const {
  if (obstacles_.empty()) return true;
  const double turn = wrap_angle(to - from);
  const double way = std::abs(turn) * outline_.reach();
  const int steps = static_cast<int>(std::ceil(way / kSlack));
  // As with the masks, the clearance is widened by half a step. At both ends the body only has to fit.
  const double widened = steps > 0 ? way / steps / 2 : 0;
  for (int i = 1; i < steps; ++i) {
    if (!free(from + turn * i / steps, widened)) return false;
  }
  return fits(from) && fits(to);
}

}  // namespace headway::nav
