#include "vision/veil.h"

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/veil.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef HEADWAY_VEIL_ROWS
#define HEADWAY_VEIL_ROWS
namespace headway::vision {

/// A row that is judged, and how far one may look from it.
struct VeilRow {
  const float *disparity, *sigma;  ///< of its first pixel; no sigma where it is null
  std::ptrdiff_t pitch;            ///< from a row to the next
  int width;
  int reach, above, below;  ///< [px]
  float steepest, steepest_torn, widest_whole;
  std::array<float*, 3> out;  ///< become NaN where there is a veil; as many as are not null
};

}  // namespace headway::vision
#endif

HWY_BEFORE_NAMESPACE();
namespace headway::vision::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Of as many pixels as D has lanes: where the slope through them is too steep for a surface. It goes from
/// the farthest known pixel of `before` to the farthest of `after`, `stride` apart.
template <class D>
HWY_INLINE hn::Mask<D> steep(D d, const VeilRow& row, int u, std::ptrdiff_t stride, int before, int after) {
  const auto own = hn::LoadU(d, row.disparity + u);
  auto low = own, high = own, length = hn::Zero(d);
  auto torn = hn::Not(hn::Eq(own, own));
  const auto look = [&](int away) HWY_ATTR {
    const std::ptrdiff_t at = u + away * stride;
    const auto there = hn::LoadU(d, row.disparity + at);
    torn = hn::Or(torn, hn::Not(hn::Eq(there, there)));
    if (row.sigma != nullptr)
      torn = hn::Or(torn, hn::Gt(hn::LoadU(d, row.sigma + at), hn::Set(d, row.widest_whole)));
    return there;
  };
  look(0);
  const auto reach_to = [&](int away, auto& end, auto& distance) HWY_ATTR {
    const auto there = look(away);
    const auto known = hn::Eq(there, there);
    end = hn::IfThenElse(known, there, end);
    distance = hn::IfThenElse(known, hn::Set(d, static_cast<float>(HWY_MAX(away, -away))), distance);
  };
  auto to_low = length;
  for (int away = 1; away <= before; ++away) reach_to(-away, low, to_low);
  for (int away = 1; away <= after; ++away) reach_to(away, high, length);
  length = hn::Add(length, to_low);
  const auto steepest = hn::IfThenElse(torn, hn::Set(d, row.steepest_torn), hn::Set(d, row.steepest));
  return hn::And(hn::Eq(own, own), hn::Gt(hn::AbsDiff(high, low), hn::Mul(steepest, length)));
}

template <class D>
HWY_INLINE void judge(D d, const VeilRow& row, int u, int left, int right) {
  const auto veil =
      hn::Or(steep(d, row, u, 1, left, right), steep(d, row, u, row.pitch, row.above, row.below));
  const auto none = hn::NaN(d);
  for (float* out : row.out)
    if (out != nullptr) hn::StoreU(hn::IfThenElse(veil, none, hn::LoadU(d, out + u)), d, out + u);
}

}  // namespace

void DropVeils(const VeilRow& row) {
  const hn::ScalableTag<float> d;
  const hn::CappedTag<float, 1> single;
  const int lanes = static_cast<int>(hn::Lanes(d)), reach = row.reach, last = row.width - 1;
  const auto at_border = [&](int u)
                             HWY_ATTR { judge(single, row, u, HWY_MIN(reach, u), HWY_MIN(reach, last - u)); };
  int u = 0;
  for (; u < HWY_MIN(reach, row.width); ++u) at_border(u);
  for (; u + lanes <= row.width - reach; u += lanes) judge(d, row, u, reach, reach);
  for (; u < row.width; ++u) at_border(u);
}

}  // namespace headway::vision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {

namespace {
HWY_EXPORT(DropVeils);
}

void drop_veils(const DisparityImage& disparity, const VeilFilter& filter, RangeView& view) {
  VeilRow row{};
  row.pitch = row.width = disparity.width;
  row.reach = filter.reach;
  row.steepest = static_cast<float>(filter.steepest);
  row.steepest_torn = static_cast<float>(filter.steepest_torn);
  row.widest_whole = static_cast<float>(filter.widest_whole);
  for (int v = 0; v < disparity.height; ++v) {
    const std::size_t first = disparity.index(0, v);
    row.disparity = disparity.values.data() + first;
    row.sigma = disparity.sigma.empty() ? nullptr : disparity.sigma.data() + first;
    row.above = std::min(filter.reach, v), row.below = std::min(filter.reach, disparity.height - 1 - v);
    row.out = {view.depth.data() + first, view.sigma_depth.data() + first,
               view.weight.empty() ? nullptr : view.weight.data() + first};
    HWY_DYNAMIC_DISPATCH(DropVeils)(row);
  }
}

}  // namespace headway::vision
#endif
