#include "nav/path_legs.h"

#include <cmath>

namespace headway::nav {

using Eigen::Vector2d;

std::vector<Leg> legs_of(const Path& path, const FloorGrid& grid) {
  std::vector<Leg> legs;
  for (std::size_t i = 1; i < path.states.size(); ++i) {
    const PathState &a = path.states[i - 1], &b = path.states[i];
    if (a.cell == b.cell) continue;
    const Vector2d way = (b.cell - a.cell).cast<double>();
    const Leg leg{grid.centre(a.cell), grid.centre(b.cell), heading_angle(b.heading),
                  std::atan2(way.y(), way.x()), b.mode == Mode::kSideway};
    const bool goes_on = !legs.empty() && legs.back().yaw == leg.yaw &&
                         legs.back().direction == leg.direction && legs.back().sideway == leg.sideway;
    if (goes_on) {
      legs.back().to = leg.to;
    } else {
      legs.push_back(leg);
    }
  }
  if (!legs.empty()) {
    legs.front().from = path.start.position();
    legs.back().to = path.end;
  }
  return legs;
}

}  // namespace headway::nav
