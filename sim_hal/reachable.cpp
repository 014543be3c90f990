#include "sim_hal/reachable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>

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

  /// Dijkstra over the eight neighbours; between two that touch at a corner, one of the cells beside it must
  /// be free.
  std::vector<Vector2d> shortest(const Vector2d& from, const Vector2d& to) {
    const Cell start = cell(from), goal = cell(to);
    if (!free(start) || !free(goal)) return {};
    std::vector<double> cost(blocked_.size(), std::numeric_limits<double>::infinity());
    std::vector<std::size_t> before(blocked_.size());
    using Entry = std::tuple<double, std::size_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    // From the goal, so that the way comes out in order.
    cost[index(goal)] = 0;
    open.emplace(0, index(goal));
    while (!open.empty()) {
      const auto [so_far, i] = open.top();
      open.pop();
      if (so_far > cost[i]) continue;
      const Cell c = at_index(i);
      if (i == index(start)) return back_from(i, index(goal), before);
      for (const auto& [dx, dy] : kNeighbours) {
        const Cell n{c.column + dx, c.row + dy};
        if (!free(n) || (!free({n.column, c.row}) && !free({c.column, n.row}))) continue;
        const double with = so_far + std::hypot(dx, dy);
        if (with >= cost[index(n)]) continue;
        cost[index(n)] = with;
        before[index(n)] = i;
        open.emplace(with, index(n));
      }
    }
    return {};
  }

 private:
  static constexpr std::array<std::array<int, 2>, 8> kNeighbours{
      {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};

  std::vector<Vector2d> back_from(std::size_t i, std::size_t last,
                                  const std::vector<std::size_t>& before) const {
    std::vector<Vector2d> way{centre(at_index(i))};
    while (i != last) {
      i = before[i];
      way.push_back(centre(at_index(i)));
    }
    return way;
  }
  std::size_t index(Cell c) const {
    return static_cast<std::size_t>(c.row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(c.column);
  }
  Cell at_index(std::size_t i) const {
    const auto columns = static_cast<std::size_t>(columns_);
    return {static_cast<int>(i % columns), static_cast<int>(i / columns)};
  }
  Cell cell(const Vector2d& p) const {
    const Vector2d q = (p - origin_) / kCell;
    return {static_cast<int>(std::floor(q.x())), static_cast<int>(std::floor(q.y()))};
  }
  Vector2d centre(Cell c) const { return origin_ + kCell * Vector2d(c.column + 0.5, c.row + 0.5); }
  std::uint8_t& at(Cell c) { return blocked_[index(c)]; }
  bool free(Cell c) {
    return c.column >= 0 && c.row >= 0 && c.column < columns_ && c.row < rows_ && at(c) == 0;
  }

  Vector2d origin_;
  int columns_, rows_;
  std::vector<std::uint8_t> blocked_;
};

Grid grid_of(const World& world, const std::vector<Solid>& solids, double clearance) {
  Grid grid(world.floor);
  for (const Solid& solid : solids) grid.block(solid, clearance + kOff);
  return grid;
}

}  // namespace

bool reachable(const World& world, const std::vector<Solid>& solids, double clearance) {
  if (!world.goal) return false;
  return grid_of(world, solids, clearance).connected(world.start.position(), world.goal->position);
}

std::vector<Vector2d> shortest_way(const World& world, const std::vector<Solid>& solids, double clearance) {
  if (!world.goal) return {};
  return grid_of(world, solids, clearance).shortest(world.start.position(), world.goal->position);
}

}  // namespace headway::sim
