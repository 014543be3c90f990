#include "nav/passing_obstacles.h"

#include <cmath>

namespace headway::nav {
namespace {

constexpr std::uint8_t kFewestPoints = 3;  // that show something standing on a cell
constexpr double kApart = 1 / 150.0;       // of the rays that are looked at, as tangents
constexpr float kLeastWeight = 0.8F;       // of points that are no wrong matches

}  // namespace

PassingObstacles::PassingObstacles(const FloorGrid& grid, const FloorMapConfig& heights)
    : grid_(grid),
      heights_(heights),
      was_free_(grid.size(), 0),
      points_(grid.size(), 0),
      stood_at_(grid.size(), kNever) {}

void PassingObstacles::look(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera,
                            Time stamp) {
  const int step = std::max(1, static_cast<int>(std::lround(view.camera.focal * kApart)));
  for (int v = 0; v < view.camera.height; v += step) {
    for (int u = 0; u < view.camera.width; u += step) {
      const std::size_t pixel = view.index(u, v);
      const auto depth = static_cast<double>(view.depth[pixel]);
      if (!(depth >= view.near && depth <= view.far)) continue;  // or nothing was measured
      if (!view.weight.empty() && view.weight[pixel] < kLeastWeight) continue;
      const Eigen::Vector3d point = map_from_camera * view.camera.point(u, v, depth);
      if (!(point.z() > heights_.floor_tolerance && point.z() < heights_.body_height)) continue;
      const Eigen::Vector2i at = grid_.cell(point.head<2>());
      if (!grid_.contains(at)) continue;
      const std::size_t cell = grid_.index(at);
      if (points_[cell] == 0) counted_.push_back(cell);
      if (points_[cell] < kFewestPoints) ++points_[cell];
    }
  }
  for (const std::size_t cell : counted_) {
    if (points_[cell] == kFewestPoints) stood_at_[cell] = std::max(stood_at_[cell], stamp);
    points_[cell] = 0;
  }
  counted_.clear();
}

bool PassingObstacles::amid_free(const Eigen::Vector2d& point) const {
  const Eigen::Vector2i cell = grid_.cell(point);
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x)
      if (const Eigen::Vector2i near = cell + Eigen::Vector2i(x, y);
          !grid_.contains(near) || !was_free(grid_.index(near)))
        return false;
  return true;
}

void PassingObstacles::see(const FloorMap& floor) {
  for (std::size_t i = 0; i < was_free_.size(); ++i) was_free_[i] |= floor.cells[i] == Floor::kFree;
}

}  // namespace headway::nav
