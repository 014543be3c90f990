#include "nav/floor_map.h"

#include <algorithm>
#include <string>
#include <utility>

#include "hal/error.h"
#include "nav/floor_projection.h"

namespace headway::nav {
namespace {

/// Goes from a cell to its neighbours and on, to each cell of a box once, as long as enter(cell) is true.
template <class Enter>
void spread(const Eigen::Vector2i& from, const Eigen::AlignedBox2i& box, const Enter& enter) {
  if (!box.contains(from)) return;
  const Eigen::Vector2i size = box.sizes() + Eigen::Vector2i::Ones();
  std::vector<std::uint8_t> been(static_cast<std::size_t>(size.prod()), 0);
  const auto visit = [&](const Eigen::Vector2i& cell) {
    const Eigen::Vector2i in_box = cell - box.min();
    const auto at = static_cast<std::size_t>(in_box.y() * size.x() + in_box.x());
    return !std::exchange(been[at], std::uint8_t{1}) && enter(cell);
  };
  std::vector<Eigen::Vector2i> open{from};
  visit(from);
  while (!open.empty()) {
    const Eigen::Vector2i cell = open.back();
    open.pop_back();
    for (const Eigen::Vector2i& step : {Eigen::Vector2i{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      if (box.contains(cell + step) && visit(cell + step)) open.emplace_back(cell + step);
  }
}

}  // namespace

FloorMap unseen_floor(const FloorGrid& grid) {
  return {grid, std::vector<Floor>(grid.size(), Floor::kUnseen), std::vector<Time>(grid.size(), kNever)};
}

void FloorMapConfig::validate() const {
  const auto refuse = [](const std::string& what) { throw InputError("floor map: " + what); };
  if (!(floor_tolerance >= 0 && floor_tolerance <= 0.5)) {
    refuse("floor_tolerance: " + std::to_string(floor_tolerance) + " m, expected 0 to 0.5 m");
  }
  if (!(body_height > floor_tolerance && body_height <= 10)) {
    refuse("body_height: " + std::to_string(body_height) +
           " m, expected more than floor_tolerance, at most 10 m");
  }
  if (voxels_to_block < 1 || voxels_to_block > 9) {
    refuse("voxels_to_block: " + std::to_string(voxels_to_block) + ", expected 1 to 9");
  }
}

FloorGrid floor_grid(const VoxelMap& map) {
  return {map.resolution(), map.lowest().head<2>(), map.size().x(), map.size().y()};
}

FloorGrid floor_grid(const VoxelMapConfig& box) {
  const BrickRange bricks = bricks_in(box);
  const Eigen::Vector2i size = kBrickEdge * (bricks.end - bricks.first).head<2>();
  return {box.resolution, (kBrickEdge * bricks.first.head<2>()).cast<double>() * box.resolution, size.x(),
          size.y()};
}

FloorMap floor_map(const VoxelMap& map, const FloorMapConfig& config) {
  FloorMap floor = unseen_floor(floor_grid(map));
  FloorProjection(floor.grid, config).update(map, floor);
  return floor;
}

Eigen::AlignedBox2i start_cells(const FloorGrid& grid, const Pose2& start, const StartArea& area) {
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(std::max(area.radius, area.footprint_half.norm()));
  const Eigen::Vector2i low = grid.cell(start.position() - reach).cwiseMax(0),
                        high = grid.cell(start.position() + reach)
                                   .cwiseMin(Eigen::Vector2i(grid.width - 1, grid.height - 1));
  return {low, high};
}

void start_clear(FloorMap& floor, const Pose2& start, const StartArea& area, Time stamp,
                 bool robot_is_there) {
  const Pose2 start_from_map = start.inverse();
  const Eigen::AlignedBox2i cells = start_cells(floor.grid, start, area);
  const auto seen_from_start = [&](const Eigen::Vector2i& cell) -> Eigen::Vector2d {
    return start_from_map * floor.grid.centre(cell);
  };
  const auto free = [&](const Eigen::Vector2i& cell) {
    const std::size_t index = floor.grid.index(cell);
    floor.cells[index] = Floor::kFree;
    floor.seen_at[index] = std::max(floor.seen_at[index], stamp);
  };
  if (robot_is_there) {
    for (int y = cells.min().y(); y <= cells.max().y(); ++y)
      for (int x = cells.min().x(); x <= cells.max().x(); ++x)
        if ((seen_from_start({x, y}).array().abs() <= area.footprint_half.array()).all()) free({x, y});
  }
  spread(floor.grid.cell(start.position()), cells, [&](const Eigen::Vector2i& cell) {
    if (is_occupied(floor.at(cell)) || seen_from_start(cell).norm() > area.radius) return false;
    free(cell);
    return true;
  });
}

}  // namespace headway::nav
