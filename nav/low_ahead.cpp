#include "nav/low_ahead.h"

#include <algorithm>
#include <cmath>

#include "nav/body_outline.h"

namespace headway::nav {

using Eigen::Vector2d, Eigen::Vector2i;

bool any_low(const FloorMap& floor) {
  return std::find(floor.cells.begin(), floor.cells.end(), Floor::kLow) != floor.cells.end();
}

std::vector<LowStretch> low_ahead(const FloorMap& floor, const Vector2d& point, double yaw, double first,
                                  double last, const GaitLimits& gait) {
  const Vector2d along(std::cos(yaw), std::sin(yaw)), left(-along.y(), along.x());
  const double cell = floor.grid.resolution / 2 * (std::abs(along.x()) + std::abs(along.y()));
  const double beside = (gait.feet_apart + gait.sole_width) / 2 + gait.over.margin + cell;
  const double around = gait.sole_length / 2 + gait.over.margin + cell;
  Vector2d low = Vector2d::Constant(1e9), high = -low;
  for (const double at : {first - around, last + around}) {
    for (const double aside : {-beside, beside}) {
      const Vector2d corner = point + (at - point.dot(along)) * along + aside * left;
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  std::vector<LowStretch> stretches;
  const Vector2i begin = floor.grid.cell(low).cwiseMax(0),
                 end = floor.grid.cell(high).cwiseMin(Vector2i(floor.grid.width - 1, floor.grid.height - 1));
  for (int y = begin.y(); y <= end.y(); ++y) {
    for (int x = begin.x(); x <= end.x(); ++x) {
      if (floor.at({x, y}) != Floor::kLow) continue;
      const Vector2d centre = floor.grid.centre({x, y});
      if (std::abs((centre - point).dot(left)) > beside) continue;
      const double at = centre.dot(along);
      if (at + around < first || at - around > last) continue;
      stretches.push_back({at - around, at + around});
    }
  }
  std::ranges::sort(stretches, {}, &LowStretch::begin);
  std::vector<LowStretch> merged;
  for (const LowStretch& s : stretches) {
    if (merged.empty() || s.begin > merged.back().end)
      merged.push_back(s);
    else
      merged.back().end = std::max(merged.back().end, s.end);
  }
  return merged;
}

bool is_on_low(const FloorMap& floor, const GaitLimits& gait, const Pose2& foot) {
  return std::ranges::any_of(sole_cells(floor.grid, gait, foot),
                             [&](const Vector2i& cell) { return floor.at(cell) == Floor::kLow; });
}

bool passes_low(const FloorMap& floor, const GaitLimits& gait, const Pose2& lift, const Pose2& landing) {
  const Vector2d way = landing.position() - lift.position();
  const int parts = 1 + static_cast<int>(2 * way.norm() / floor.grid.resolution);
  for (int i = 0; i <= parts; ++i) {
    const double share = static_cast<double>(i) / parts;
    const Vector2d at = lift.position() + share * way;
    const double yaw = lift.yaw + share * wrap_angle(landing.yaw - lift.yaw);
    if (is_on_low(floor, gait, {at.x(), at.y(), yaw})) return true;
  }
  return false;
}

}  // namespace headway::nav
