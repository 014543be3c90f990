#include "nav/ground.h"

#include <algorithm>
#include <numbers>

namespace headway::nav {

using Eigen::Vector2d;
using Eigen::Vector2i;

namespace {

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
  const Floor floor = map_.cells[map_.grid.index(cell)];
  if (floor == Floor::kBlocked) return Ground::kBlocked;
  if (floor == Floor::kFree || unseen_ == UnseenFloor::kFree) return Ground::kFree;
  return unseen_ == UnseenFloor::kBlocked ? Ground::kBlocked : Ground::kUnseen;
}

Ground GroundView::near_start(const Vector2i& cell, Ground on_map) const {
  if (on_map == Ground::kFree) return on_map;
  const double size = map_.grid.resolution;
  const double distance = distance_to_square(outline_, start_, map_.grid.centre(cell), size);
  if (distance <= 0) return Ground::kFree;
  // Masks stand on cell centres, up to half a cell's diagonal off the place where the body really is.
  const double too_near = outline_.clearance() + size / std::numbers::sqrt2;
  return is_obstacle(on_map) && distance <= too_near ? Ground::kTight : on_map;
}

Ground GroundView::at(const Vector2i& cell) const {
  const Ground on_map = on_the_map(cell);
  if (!start_is_free_) return on_map;
  const Vector2d offset = map_.grid.centre(cell) - start_.position();
  const bool near = offset.cwiseAbs().maxCoeff() <= near_start_reach();
  return near ? near_start(cell, on_map) : on_map;
}

void GroundView::survey(std::vector<Ground>& into) const {
  const FloorGrid& grid = map_.grid;
  into.resize(grid.size());
  const auto as = [&](Floor f) {
    if (f == Floor::kBlocked || (f == Floor::kUnseen && unseen_ == UnseenFloor::kBlocked)) {
      return Ground::kBlocked;
    }
    return f == Floor::kUnseen && unseen_ == UnseenFloor::kCostly ? Ground::kUnseen : Ground::kFree;
  };
  std::transform(map_.cells.begin(), map_.cells.end(), into.begin(), as);
  if (!start_is_free_) return;
  const Vector2d reach = Vector2d::Constant(near_start_reach());
  const Vector2i low = grid.cell(start_.position() - reach).cwiseMax(0);
  const Vector2i high =
      grid.cell(start_.position() + reach).cwiseMin(Vector2i(grid.width - 1, grid.height - 1));
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) into[grid.index({x, y})] = at({x, y});
  }
}

bool GroundView::blocks(const Vector2i& cell, const Mask& mask, const Mask& bare_mask) const {
  return any_cell(cell, mask, [&](const Vector2i& c) { return at(c) == Ground::kBlocked; }) ||
         any_cell(cell, bare_mask, [&](const Vector2i& c) { return at(c) == Ground::kTight; });
}

}  // namespace headway::nav
