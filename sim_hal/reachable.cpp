#include "sim_hal/reachable.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace headway::sim {

using Eigen::Vector2d;

namespace {

constexpr double kCell = 0.05;
// On its way from cell to cell, and from a place to its cell's centre, the disc is never farther than this
// from a centre.
constexpr double kOff = 0.036;

struct Cell {
  int column, row;
};

class Grid {
 public:
  explicit Grid(const Floor& floor)
      : origin_(floor.centre - floor.size / 2),
        columns_(static_cast<int>(floor.size.x() / kCell)),
        rows_(static_cast<int>(floor.size.y() / kCell)),
        blocked_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0) {}

  void block(const Solid& solid, double clearance) {
    const double far = solid.reach() + clearance;
    const Cell low = cell(solid.pose.position() - Vector2d(far, far)),
               high = cell(solid.pose.position() + Vector2d(far, far));
    for (int row = std::max(low.row, 0); row <= std::min(high.row, rows_ - 1); ++row)
      for (int column = std::max(low.column, 0); column <= std::min(high.column, columns_ - 1); ++column) {
        const Vector2d c = centre({column, row});
        if (floor_distance(solid, Solid::cylinder({c.x(), c.y(), 0}, 0, 1)) < clearance)
          at({column, row}) = 1;
      }
  }

  bool connected(const Vector2d& from, const Vector2d& to) {
    const Cell goal = cell(to);
    std::vector<Cell> open{cell(from)};
    if (!free(goal) || !free(open.front())) return false;
    while (!open.empty()) {
      const Cell c = open.back();
      open.pop_back();
      if (c.column == goal.column && c.row == goal.row) return true;
      for (const Cell n :
           {Cell{c.column + 1, c.row}, {c.column - 1, c.row}, {c.column, c.row + 1}, {c.column, c.row - 1}})
        if (free(n)) {
          at(n) = 1;
          open.push_back(n);
        }
    }
    return false;
  }

 private:
  Cell cell(const Vector2d& p) const {
    const Vector2d q = (p - origin_) / kCell;
    return {static_cast<int>(std::floor(q.x())), static_cast<int>(std::floor(q.y()))};
  }
  Vector2d centre(Cell c) const { return origin_ + kCell * Vector2d(c.column + 0.5, c.row + 0.5); }
  std::uint8_t& at(Cell c) {
    return blocked_[static_cast<std::size_t>(c.row) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(c.column)];
  }
  bool free(Cell c) {
    return c.column >= 0 && c.row >= 0 && c.column < columns_ && c.row < rows_ && at(c) == 0;
  }

  Vector2d origin_;
  int columns_, rows_;
  std::vector<std::uint8_t> blocked_;
};

}  // namespace

bool reachable(const World& world, const std::vector<Solid>& solids, double clearance) {
  if (!world.goal) return false;
  Grid grid(world.floor);
  for (const Solid& solid : solids) grid.block(solid, clearance + kOff);
  return grid.connected(world.start.position(), world.goal->position);
}

}  // namespace headway::sim
