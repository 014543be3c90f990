#include "nav/ground.h"

#include <algorithm>
#include <numbers>

namespace headway::nav {

using Eigen::Vector2d;
using Eigen::Vector2i;

namespace {

/// Masks stand on cell centres, up to half a cell's diagonal off the place where the body really is.
double off_centre(double cell_size) { return cell_size / std::numbers::sqrt2; }

template <class Is>
bool any_cell(const Vector2i& cell, const Mask& mask, const Is& is) {
  for (const Mask::Run& run : mask.runs) {
    for (int x = run.first; x <= run.last; ++x) {
      if (is(Vector2i(cell.x() + x, cell.y() + run.dy))) return true;
    }
  }
  return false;
}

}  // namespace

Ground GroundView::on_the_map(const Vector2i& cell) const {
  if (!map_.grid.contains(cell)) return Ground::kBlocked;
  return ground_of(map_.cells[map_.grid.index(cell)], unseen_);
}

Ground GroundView::as_seen_from_start(const Vector2i& cell, Ground on_map) const {
  if (on_map == Ground::kFree) return on_map;
  const double size = map_.grid.resolution;
  const double distance = distance_to_square(outline_, start_, map_.grid.centre(cell), size);
  if (distance <= 0) return Ground::kFree;
  const double too_near = outline_.clearance() + off_centre(size);
  return is_obstacle(on_map) && distance <= too_near ? Ground::kTight : on_map;
}

/// From the start to the centre of a cell that it matters to, along x or y: half a cell's side more than to
/// the cell itself.
double GroundView::near_start_reach() const {
  const double size = map_.grid.resolution;
  return outline_.reach() + off_centre(size) + size / 2;
}

Ground GroundView::at(const Vector2i& cell) const {
  const Ground on_map = on_the_map(cell);
  if (!start_is_free_) return on_map;
  const Vector2d offset = map_.grid.centre(cell) - start_.position();
  const bool near = offset.cwiseAbs().maxCoeff() <= near_start_reach();
  return near ? as_seen_from_start(cell, on_map) : on_map;
}

CellBox GroundView::near_start() const {
  if (!start_is_free_) return {};
  const FloorGrid& grid = map_.grid;
  const Vector2d reach = Vector2d::Constant(near_start_reach());
  return {grid.cell(start_.position() - reach).cwiseMax(0),
          grid.cell(start_.position() + reach).cwiseMin(Vector2i(grid.width - 1, grid.height - 1))};
}

bool GroundView::blocks(const Vector2i& cell, const Mask& mask, const Mask& bare_mask) const {
  return any_cell(cell, mask, [&](const Vector2i& c) { return at(c) == Ground::kBlocked; }) ||
         any_cell(cell, bare_mask, [&](const Vector2i& c) { return at(c) == Ground::kTight; });
}

bool GroundView::any_low(const Vector2i& cell, const Mask& mask) const {
  return any_cell(cell, mask, [&](const Vector2i& c) { return at(c) == Ground::kLow; });
}

}  // namespace headway::nav
