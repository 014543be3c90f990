#include "nav/motion_costs.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace headway::nav {

Ticks in_ticks(double seconds, double tick) {
  return static_cast<Ticks>(std::clamp(std::round(seconds / tick), 0.0, static_cast<double>(kTooDear)));
}

MotionCosts::MotionCosts(const PlannerConfig& config, const GaitLimits& gait, double resolution)
    : tick(gait.forward_seconds(resolution) / config.ticks_per_cell),
      mode_change(in_ticks(config.mode_change, tick)) {
  for (std::size_t diagonal = 0; diagonal < 2; ++diagonal) {
    const double length = resolution * (diagonal ? std::numbers::sqrt2 : 1);
    for (std::size_t eighths = 0; eighths < 3; ++eighths) {
      const double angle = static_cast<double>(eighths) * std::numbers::pi / 4;
      const double straight = gait.forward_seconds(length), turn = gait.turn_seconds(angle);
      forward[diagonal][eighths] = sum(in_ticks(straight, tick), in_ticks(config.turn_price * turn, tick));
      sideway[diagonal][eighths] = in_ticks(std::max(gait.sideway_seconds(length * std::sin(angle)),
                                                     gait.forward_seconds(length * std::cos(angle))),
                                            tick);
    }
    least[diagonal] = std::min({forward[diagonal][0], sideway[diagonal][1], sideway[diagonal][2]});
  }
}

Ticks MotionCosts::of(const Motion& m) const {
  const auto diagonal = static_cast<std::size_t>(m.direction() % 2);
  const auto eighths = static_cast<std::size_t>(std::abs(m.turn()));
  return m.mode() == Mode::kForward ? forward[diagonal][eighths] : sideway[diagonal][eighths];
}

Ticks MotionCosts::walking(const Motion& m) const {
  return m.mode() == Mode::kForward ? forward[static_cast<std::size_t>(m.direction() % 2)][0] : of(m);
}

}  // namespace headway::nav
