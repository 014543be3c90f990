#include "vision/disparity_sigma.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/disparity_sigma.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef HEADWAY_SIGMA_ROWS
#define HEADWAY_SIGMA_ROWS
namespace headway::vision {

struct SigmaRow {
  const float *disparity, *doubt;  ///< of its first pixel; no doubt where it is null
  std::ptrdiff_t pitch;            ///< from a row to the next
  int width;
  bool between_rows;  ///< there are neighbours above and below
  float base, clear, doubtful, jump;
};
constexpr int kNeighbour = 2;  // [px] away

}  // namespace headway::vision
#endif

HWY_BEFORE_NAMESPACE();
namespace headway::vision::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Of as many pixels from `u` on as D has lanes. How far the disparity lies off the mean of two opposite
/// neighbours, at the most. Pairs that the image's border, a step or a pixel without a match breaks tell
/// nothing: comparing with NaN is false.
template <class D>
HWY_INLINE hn::Vec<D> bend(D d, const SigmaRow& row, int u, bool between_columns) {
  const float* at = row.disparity + u;
  const auto own = hn::LoadU(d, at), jump = hn::Set(d, row.jump);
  auto most = hn::Zero(d);
  const auto compare = [&](std::ptrdiff_t way) HWY_ATTR {
    const auto after = hn::Sub(hn::LoadU(d, at + way), own), before = hn::Sub(hn::LoadU(d, at - way), own);
    const auto same_surface = hn::And(hn::Le(hn::Abs(after), jump), hn::Le(hn::Abs(before), jump));
    most = hn::Max(most, hn::IfThenElseZero(same_surface, hn::Abs(hn::Add(after, before))));
  };
  const std::ptrdiff_t down = kNeighbour * row.pitch;
  if (between_columns) compare(kNeighbour);
  if (row.between_rows) compare(down);
  if (between_columns && row.between_rows) compare(down + kNeighbour), compare(down - kNeighbour);
  return hn::Mul(most, hn::Set(d, 0.5F));
}

template <class D>
HWY_INLINE void estimate(D d, const SigmaRow& row, int u, bool between_columns, float* sigma) {
  const auto own = hn::LoadU(d, row.disparity + u);
  auto base = hn::Set(d, row.base);
  if (row.doubt != nullptr) {
    const auto doubt = hn::LoadU(d, row.doubt + u);
    const auto grown = hn::Mul(hn::Mul(hn::Set(d, row.doubtful), doubt), doubt);
    base = hn::Mul(base, hn::Add(hn::Set(d, row.clear), grown));
  }
  const auto bent = bend(d, row, u, between_columns);
  const auto both = hn::Sqrt(hn::Add(hn::Mul(base, base), hn::Mul(bent, bent)));
  hn::StoreU(hn::IfThenElse(hn::Eq(own, own), both, own), d, sigma + u);
}

}  // namespace

void EstimateSigma(const SigmaRow& row, float* sigma) {
  const hn::ScalableTag<float> d;
  const hn::CappedTag<float, 1> single;
  const int lanes = static_cast<int>(hn::Lanes(d)), inner = row.width - kNeighbour;
  int u = 0;
  for (; u < HWY_MIN(kNeighbour, row.width); ++u) estimate(single, row, u, false, sigma);
  for (; u + lanes <= inner; u += lanes) estimate(d, row, u, true, sigma);
  for (; u < row.width; ++u) estimate(single, row, u, u < inner, sigma);
}

}  // namespace headway::vision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {

namespace {
HWY_EXPORT(EstimateSigma);
}

void estimate_sigma(const SigmaModel& model, DisparityImage& disparity) {
  disparity.sigma.resize(disparity.values.size());
  SigmaRow row{};
  row.pitch = row.width = disparity.width;
  row.base = static_cast<float>(model.base), row.jump = static_cast<float>(model.jump);
  row.clear = static_cast<float>(model.clear), row.doubtful = static_cast<float>(model.doubtful);
  for (int v = 0; v < disparity.height; ++v) {
    const std::size_t first = disparity.index(0, v);
    row.disparity = disparity.values.data() + first;
    row.doubt = disparity.doubt.empty() ? nullptr : disparity.doubt.data() + first;
    row.between_rows = v >= kNeighbour && v + kNeighbour < disparity.height;
    HWY_DYNAMIC_DISPATCH(EstimateSigma)(row, disparity.sigma.data() + first);
  }
}

}  // namespace headway::vision
#endif
