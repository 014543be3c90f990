#include "vision/doubt.h"

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/doubt.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef HEADWAY_DOUBT_ROWS
#define HEADWAY_DOUBT_ROWS
namespace headway::vision {

/// The rows two pixels above, of, and two pixels below those that are judged.
struct DoubtRows {
  std::array<const float*, 3> disparity, ambiguity;
  int width;
  float jump;
};
constexpr int kReach = 2;  // [px]

}  // namespace headway::vision
#endif

HWY_BEFORE_NAMESPACE();
namespace headway::vision::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Of as many pixels from `u` on as D has lanes. Comparing with NaN is false, so that no match counts as
/// another surface.
template <class D>
HWY_INLINE void judge(D d, const DoubtRows& rows, int u, float* doubt) {
  const auto one = hn::Set(d, 1.0F), jump = hn::Set(d, rows.jump);
  const auto own = hn::LoadU(d, rows.disparity[1] + u);
  const int columns[] = {HWY_MAX(0, u - kReach), u, HWY_MIN(rows.width - 1, u + kReach)};
  auto sum = hn::Zero(d);
  for (std::size_t row = 0; row < 3; ++row)
    for (const int column : columns) {
      const auto other = hn::LoadU(d, rows.disparity[row] + column);
      const auto same_surface = hn::Le(hn::AbsDiff(other, own), jump);
      sum = hn::Add(sum, hn::IfThenElse(same_surface, hn::LoadU(d, rows.ambiguity[row] + column), one));
    }
  const auto mean = hn::Mul(sum, hn::Set(d, 1.0F / 9));
  hn::StoreU(hn::IfThenElse(hn::Eq(own, own), mean, own), d, doubt + u);
}

}  // namespace

void DoubtRow(const DoubtRows& rows, float* doubt) {
  const hn::ScalableTag<float> d;
  const hn::CappedTag<float, 1> single;
  const int lanes = static_cast<int>(hn::Lanes(d)), inner = rows.width - kReach;
  int u = 0;
  for (; u < HWY_MIN(kReach, rows.width); ++u) judge(single, rows, u, doubt);
  for (; u + lanes <= inner; u += lanes) judge(d, rows, u, doubt);
  for (; u < rows.width; ++u) judge(single, rows, u, doubt);
}

}  // namespace headway::vision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {

namespace {
HWY_EXPORT(DoubtRow);
}

void estimate_doubt(const DoubtModel& model, DisparityImage& disparity) {
  disparity.doubt.clear();
  if (disparity.ambiguity.empty()) return;
  disparity.doubt.resize(disparity.values.size());
  DoubtRows rows{{}, {}, disparity.width, static_cast<float>(model.jump)};
  for (int v = 0; v < disparity.height; ++v) {
    const int beside[] = {std::max(0, v - kReach), v, std::min(disparity.height - 1, v + kReach)};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t start = disparity.index(0, beside[i]);
      rows.disparity[i] = disparity.values.data() + start,
      rows.ambiguity[i] = disparity.ambiguity.data() + start;
    }
    HWY_DYNAMIC_DISPATCH(DoubtRow)(rows, disparity.doubt.data() + disparity.index(0, v));
  }
}

}  // namespace headway::vision
#endif
