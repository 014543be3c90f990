#include "vision/visible_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/visible_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace headway::vision {

#ifndef HEADWAY_ROW_TASK
#define HEADWAY_ROW_TASK
namespace {

constexpr std::size_t kMostLanes = 16;  // more than any instruction set has for doubles

struct RowTask {
  std::span<RowBound> lower, upper, whole;
  double doubt;  // the largest of lower and upper
  const VoxelGrid& grid;
  std::span<const Eigen::Vector4d> rows;
  RowSpan* spans;  // of all rows, and room for kMostLanes more
};

RowSpan exact_span(std::span<const Eigen::Vector4d> rows, const VoxelGrid& grid, int j, int k);

}  // namespace
#endif

namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// As many rows as there are lanes, from row j of layer k on.
template <class D>
HWY_INLINE void rows_at(D d, const RowTask& t, int j, int k) {
  using V = hn::Vec<D>;
  const V y = hn::Iota(d, static_cast<double>(j));
  const auto at = [&](const RowBound& b)
                      HWY_ATTR { return hn::Add(hn::Set(d, b.here), hn::Mul(hn::Set(d, b.along_y), y)); };
  const double before = -0.5, behind = t.grid.nx - 0.5;  // off the whole numbers, where nothing is in doubt
  V low = hn::Set(d, before), high = hn::Set(d, behind);
  for (const RowBound& b : t.lower) low = hn::Max(low, at(b));
  for (const RowBound& b : t.upper) high = hn::Min(high, at(b));
  const V doubt = hn::Set(d, t.doubt);
  auto doubtful = hn::Or(hn::Le(hn::Abs(hn::Sub(low, hn::Round(low))), doubt),
                         hn::Le(hn::Abs(hn::Sub(high, hn::Round(high))), doubt));
  auto empty = hn::Lt(high, low);
  for (const RowBound& b : t.whole) {
    const V side_of_row = at(b), least = hn::Set(d, b.doubt);
    empty = hn::Or(empty, hn::Lt(side_of_row, hn::Neg(least)));
    doubtful = hn::Or(doubtful, hn::Not(hn::Gt(hn::Abs(side_of_row), least)));  // also where it is NaN
  }
  V first = hn::Ceil(hn::Min(low, hn::Set(d, behind))), last = hn::Floor(hn::Max(high, hn::Set(d, before)));
  last = hn::Add(last, hn::Set(d, 1.0));
  empty = hn::Or(empty, hn::Le(last, first));
  const hn::Rebind<std::int32_t, D> whole_numbers;
  HWY_ALIGN std::int32_t firsts[kMostLanes], lasts[kMostLanes];
  hn::Store(hn::DemoteTo(whole_numbers, hn::IfThenZeroElse(empty, first)), whole_numbers, firsts);
  hn::Store(hn::DemoteTo(whole_numbers, hn::IfThenZeroElse(empty, last)), whole_numbers, lasts);
  RowSpan* spans = t.spans + static_cast<std::size_t>(k) * static_cast<std::size_t>(t.grid.ny) + j;
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) spans[lane] = {firsts[lane], lasts[lane]};
  if (hn::AllFalse(d, doubtful)) return;
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, doubtful, bits);
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane)
    if (bits[lane / 8] >> lane % 8 & 1)
      spans[lane] = exact_span(t.rows, t.grid, j + static_cast<int>(lane), k);
}

// The last rows of a layer spill over into the next one, which comes after and overwrites them.
void all_rows(const RowTask& t) {
  const hn::ScalableTag<double> d;
  for (int k = 0; k < t.grid.nz; ++k) {
    for (const auto bounds : {t.lower, t.upper, t.whole})
      for (RowBound& b : bounds) b.here = b.at + b.along_z * k;
    for (int j = 0; j < t.grid.ny; j += static_cast<int>(hn::Lanes(d))) rows_at(d, t, j, k);
  }
}

// Single precision in, double inside: then each sum is that of `side`.
template <class D>
HWY_INLINE void points_at(D d, std::span<const Eigen::Vector4d> rows, const float* x, const float* y,
                          const float* z, std::uint8_t* inside) {
  const hn::Rebind<float, D> single;
  const auto px = hn::PromoteTo(d, hn::LoadU(single, x)), py = hn::PromoteTo(d, hn::LoadU(single, y)),
             pz = hn::PromoteTo(d, hn::LoadU(single, z));
  auto in = hn::Eq(hn::Zero(d), hn::Zero(d));
  for (const Eigen::Vector4d& row : rows) {
    const auto along = hn::Add(hn::Mul(hn::Set(d, row[0]), px), hn::Mul(hn::Set(d, row[1]), py));
    const auto distance = hn::Add(hn::Add(along, hn::Mul(hn::Set(d, row[2]), pz)), hn::Set(d, row[3]));
    in = hn::And(in, hn::Ge(distance, hn::Zero(d)));
  }
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, in, bits);
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) inside[lane] = bits[lane / 8] >> lane % 8 & 1;
}

void all_points(std::span<const Eigen::Vector4d> rows, const float* x, const float* y, const float* z,
                std::uint8_t* inside, std::size_t count) {
  const hn::ScalableTag<double> many;
  const hn::CappedTag<double, 1> one;
  std::size_t i = 0;
  for (; i + hn::Lanes(many) <= count; i += hn::Lanes(many))
    points_at(many, rows, x + i, y + i, z + i, inside + i);
  for (; i < count; ++i) points_at(one, rows, x + i, y + i, z + i, inside + i);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {
namespace {

HWY_EXPORT(all_rows);
HWY_EXPORT(all_points);

// The first of [first, last) from which on `holds` is true, by bisection; `last` when there is none.
template <class Holds>
int first_where(int first, int last, const Holds& holds) {
  while (first < last) {
    const int middle = first + (last - first) / 2;
    if (holds(middle))
      last = middle;
    else
      first = middle + 1;
  }
  return first;
}

// With the very test of a point. Rounding keeps order, so along a row `side` never falls (or never rises)
// even in floating point, and each half-space leaves one interval.
RowSpan exact_span(std::span<const Eigen::Vector4d> rows, const VoxelGrid& grid, int j, int k) {
  const double y = grid.centre(1, j), z = grid.centre(2, k);
  RowSpan span{0, grid.nx};
  for (const Eigen::Vector4d& row : rows) {
    const auto inside = [&](int i) { return side(row, grid.centre(0, i), y, z) >= 0; };
    if (row[0] < 0)
      span.last = first_where(span.first, span.last, [&](int i) { return !inside(i); });
    else
      span.first = first_where(span.first, span.last, inside);
    if (span.first >= span.last) return {};
  }
  return span;
}

// The largest that a coordinate of the grid becomes along an axis.
double farthest(const VoxelGrid& grid, int axis, int n) {
  return std::max(std::abs(grid.centre(axis, 0)), std::abs(grid.centre(axis, n)));
}

}  // namespace

void contains(std::span<const Eigen::Vector4d> rows, std::span<const float> x, std::span<const float> y,
              std::span<const float> z, std::span<std::uint8_t> inside) {
  const std::size_t count = std::min({x.size(), y.size(), z.size(), inside.size()});
  HWY_DYNAMIC_DISPATCH(all_points)(rows, x.data(), y.data(), z.data(), inside.data(), count);
}

void VisibleRows::add_bound(const Eigen::Vector4d& row, const VoxelGrid& grid) {
  // side = slope i + at + along_y j + along_z k
  const double slope = row[0] * grid.resolution, along_y = row[1] * grid.resolution,
               along_z = row[2] * grid.resolution;
  const double at = side(row, grid.centre(0, 0), grid.centre(1, 0), grid.centre(2, 0));
  // A dozen roundings, each of at most half an epsilon of the largest sum; with room to spare.
  const double largest = std::abs(row[0]) * farthest(grid, 0, grid.nx) +
                         std::abs(row[1]) * farthest(grid, 1, grid.ny) +
                         std::abs(row[2]) * farthest(grid, 2, grid.nz) + std::abs(row[3]);
  const double rounding = 64 * std::numeric_limits<double>::epsilon() * largest;
  constexpr double kClear = 0.25;  // voxels
  if (rounding < kClear * std::abs(slope))
    (slope > 0 ? lower_ : upper_)
        .push_back({-at / slope, -along_y / slope, -along_z / slope, rounding / std::abs(slope), 0});
  else
    whole_.push_back({at, along_y, along_z, rounding + std::abs(slope) * grid.nx, 0});
}

std::span<const RowSpan> VisibleRows::find(std::span<const Eigen::Vector4d> rows, const VoxelGrid& grid,
                                           const Eigen::Isometry3d& map_from_camera) {
  for (auto* bounds : {&lower_, &upper_, &whole_}) bounds->clear();
  in_map_.clear();
  for (const Eigen::Vector4d& row : rows) {
    in_map_.push_back(moved(row, map_from_camera));
    add_bound(in_map_.back(), grid);
  }
  double doubt = 0;
  for (const auto* bounds : {&lower_, &upper_})
    for (const RowBound& b : *bounds) doubt = std::max(doubt, b.doubt);
  const std::size_t count =
      static_cast<std::size_t>(std::max(grid.ny, 0)) * static_cast<std::size_t>(std::max(grid.nz, 0));
  spans_.resize(count + kMostLanes);
  HWY_DYNAMIC_DISPATCH(all_rows)({lower_, upper_, whole_, doubt, grid, in_map_, spans_.data()});
  return {spans_.data(), count};
}

}  // namespace headway::vision
#endif
