#include "nav/inverse_depth.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/inverse_depth.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set. Only exact operations are used (no
// approximate reciprocals, no fused sums), so that all of them give the same bytes.
HWY_BEFORE_NAMESPACE();
namespace headway::nav {

#ifndef HEADWAY_DEPTH_ROWS
#define HEADWAY_DEPTH_ROWS
namespace {

constexpr float kTiny = 1e-6F;  // [1/m], less than any inverse depth

// Values of one pixel differ by the noise of two, so that pixels of a block may lie farther apart than means.
constexpr float kPixelSigmas = 7, kMeanSigmas = 4;
constexpr float kShared = 9;  // samples of one mean, away from edges

struct PixelRow {
  const float *depth, *sigma, *weight;  // weight may be null
};

struct PixelRows {
  PixelRow upper, lower;
  int width;
  float near, least_weight;
};

struct OutRow {
  float *w, *sigma;
  int width;
};

struct MeanRows {
  const float* rows[3];  // above, here, below
  const float* sigma;
  int reach, supporters, width;
  float resolution;
  float* out;
  float* mean_sigma;  // may be null
};

}  // namespace
#endif

namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr D d;
constexpr hn::RebindToSigned<D> di;

HWY_INLINE int lanes() { return static_cast<int>(hn::Lanes(d)); }
HWY_INLINE V set(float value) { return hn::Set(d, value); }

/// From x on; unless it is `whole`, the row may end before the vector does, and zeros follow.
template <bool kWhole>
HWY_INLINE V load(const float* row, int x, int width) {
  if (kWhole) return hn::LoadU(d, row + x);
  HWY_ALIGN float some[HWY_MAX_BYTES / sizeof(float)] = {};
  for (int i = 0; i < lanes() && x + i < width; ++i) some[i] = row[x + i];
  return hn::Load(d, some);
}

struct Sample {
  V w, sigma;
};

/// A pixel whose sigma exceeds its depth, or is not a number, tells nothing.
template <bool kWhole>
HWY_INLINE Sample pixels(const PixelRows& in, const PixelRow& row, int x) {
  const V depth = load<kWhole>(row.depth, x, in.width), sigma = load<kWhole>(row.sigma, x, in.width);
  auto known = hn::And(hn::Ge(depth, set(in.near)), hn::Lt(sigma, depth));
  if (row.weight != nullptr)
    known = hn::And(known, hn::Ge(load<kWhole>(row.weight, x, in.width), set(in.least_weight)));
  const V w = hn::IfThenElseZero(known, hn::Div(set(1), depth));
  return {w, hn::Mul(hn::IfThenElseZero(known, sigma), hn::Mul(w, w))};
}

/// -1 where the mask is true, to count with.
HWY_INLINE hn::Vec<decltype(di)> one_less(hn::Mask<D> mask) {
  return hn::VecFromMask(di, hn::RebindMask(di, mask));
}

/// The mean of the nearest two or more of four that lie on one surface, within `sigmas` of each other, with
/// the mean of their sigmas; zero without them. If `lone_counts`, one is enough.
HWY_INLINE Sample near_cluster(const Sample& p0, const Sample& p1, const Sample& p2, const Sample& p3,
                               float sigmas, bool lone_counts, float resolution) {
  const V a = hn::Max(p0.w, p1.w), b = hn::Min(p0.w, p1.w), e = hn::Max(p2.w, p3.w), f = hn::Min(p2.w, p3.w);
  const V first = hn::Max(a, e), m = hn::Min(a, e), n = hn::Max(b, f);
  const V second = hn::Max(m, n), third = hn::Min(m, n);
  const V widest = hn::Max(hn::Max(p0.sigma, p1.sigma), hn::Max(p2.sigma, p3.sigma));
  const V apart = hn::Max(hn::Mul(set(sigmas), widest), hn::Mul(set(resolution), hn::Mul(first, first)));
  V top = first;
  if (!lone_counts) {
    const auto lone = hn::Gt(hn::Sub(first, second), apart);
    const auto two_lone = hn::And(lone, hn::Gt(hn::Sub(second, third), apart));
    top = hn::IfThenElse(two_lone, third, hn::IfThenElse(lone, second, first));
  }
  const V least = hn::Max(hn::Sub(top, apart), set(kTiny));
  Sample sum{hn::Zero(d), hn::Zero(d)};
  auto less = hn::Zero(di);
  for (const Sample* p : {&p0, &p1, &p2, &p3}) {
    const auto in = hn::And(hn::Ge(p->w, least), hn::Le(p->w, top));
    sum.w = hn::Add(sum.w, hn::IfThenElseZero(in, p->w));
    sum.sigma = hn::Add(sum.sigma, hn::IfThenElseZero(in, p->sigma));
    less = hn::Add(less, one_less(in));
  }
  const auto is = [&](int count) HWY_ATTR { return hn::RebindMask(d, hn::Eq(less, hn::Set(di, -count))); };
  V share = hn::IfThenElse(is(4), set(0.25F), set(1.0F / 3));
  share = hn::IfThenElse(is(2), set(0.5F), share);
  share = hn::IfThenElse(is(1), set(lone_counts ? 1 : 0), share);
  return {hn::Mul(sum.w, share), hn::Mul(sum.sigma, share)};
}

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE V even(V a, V) { return a; }
HWY_INLINE V odd(V, V b) { return b; }
#else
HWY_INLINE V even(V a, V b) { return hn::ConcatEven(d, b, a); }
HWY_INLINE V odd(V a, V b) { return hn::ConcatOdd(d, b, a); }
#endif

/// Four vectors (left and right above, left and right below) to half the size each way.
HWY_INLINE void store_half(const OutRow& out, int x, const Sample& al, const Sample& ar, const Sample& bl,
                           const Sample& br, float sigmas, bool lone_counts, float resolution) {
  const Sample mean =
      near_cluster({even(al.w, ar.w), even(al.sigma, ar.sigma)}, {odd(al.w, ar.w), odd(al.sigma, ar.sigma)},
                   {even(bl.w, br.w), even(bl.sigma, br.sigma)}, {odd(bl.w, br.w), odd(bl.sigma, br.sigma)},
                   sigmas, lone_counts, resolution);
  const auto inside = hn::FirstN(d, static_cast<std::size_t>(out.width - x));
  hn::StoreU(hn::IfThenElseZero(inside, mean.w), d, out.w + x);
  hn::StoreU(hn::IfThenElseZero(inside, mean.sigma), d, out.sigma + x);
}

template <bool kWhole>
HWY_INLINE void halve_block(const PixelRows& in, float resolution, const OutRow& out, int x) {
  const Sample al = pixels<kWhole>(in, in.upper, 2 * x), ar = pixels<kWhole>(in, in.upper, 2 * x + lanes()),
               bl = pixels<kWhole>(in, in.lower, 2 * x), br = pixels<kWhole>(in, in.lower, 2 * x + lanes());
  store_half(out, x, al, ar, bl, br, kPixelSigmas, false, resolution);
}

void halve_pixels(const PixelRows& in, float resolution, const OutRow& out) {
  int x = 0;
  for (; 2 * (x + lanes()) <= in.width; x += lanes()) halve_block<true>(in, resolution, out, x);
  for (; x < out.width; x += lanes()) halve_block<false>(in, resolution, out, x);
}

void halve_again(const InverseDepth& two_rows, float resolution, const OutRow& out) {
  for (int x = 0; x < out.width; x += lanes()) {
    const auto at = [&](int y, int i) HWY_ATTR -> Sample {
      return {hn::LoadU(d, two_rows.w.row(y) + i), hn::LoadU(d, two_rows.sigma.row(y) + i)};
    };
    store_half(out, x, at(0, 2 * x), at(0, 2 * x + lanes()), at(1, 2 * x), at(1, 2 * x + lanes()),
               kMeanSigmas, true, resolution);
  }
}

void keep_pixels(const PixelRows& in, const OutRow& out) {
  for (int x = 0; x < out.width; x += lanes()) {
    const Sample p = pixels<false>(in, in.upper, x);  // zeros behind the row's end
    hn::StoreU(p.w, d, out.w + x);
    hn::StoreU(p.sigma, d, out.sigma + x);
  }
}

struct Sum {
  V of_values;
  hn::Vec<decltype(di)> less;  // by their number
};

HWY_INLINE void add_same(V w, V low, V high, Sum& sum) {
  const auto same = hn::And(hn::Ge(w, low), hn::Le(w, high));
  sum.of_values = hn::Add(sum.of_values, hn::IfThenElseZero(same, w));
  sum.less = hn::Add(sum.less, one_less(same));
}

HWY_INLINE void add_row(const float* row, int reach, V low, V high, Sum& sum) {
  add_same(hn::LoadU(d, row - reach), low, high, sum);
  add_same(hn::LoadU(d, row), low, high, sum);
  add_same(hn::LoadU(d, row + reach), low, high, sum);
}

std::size_t smooth_row(const MeanRows& in) {
  std::size_t dropped = 0;
  const auto too_few = hn::Set(di, -in.supporters);
  for (int x = 0; x < in.width; x += lanes()) {
    const V w = hn::LoadU(d, in.rows[1] + x), sigma = hn::LoadU(d, in.sigma + x);
    const V apart = hn::Max(hn::Mul(set(kMeanSigmas), sigma), hn::Mul(set(in.resolution), hn::Mul(w, w)));
    const V low = hn::Max(hn::Sub(w, apart), set(kTiny)), high = hn::Add(w, apart);
    Sum sum{hn::Zero(d), hn::Zero(di)};
    add_row(in.rows[0] + x, in.reach, low, high, sum);
    add_row(in.rows[1] + x, in.reach, low, high, sum);
    add_row(in.rows[2] + x, in.reach, low, high, sum);
    const auto known = hn::Gt(w, set(kTiny));
    const auto kept = hn::And(known, hn::RebindMask(d, hn::Gt(too_few, sum.less)));
    dropped += hn::CountTrue(d, hn::AndNot(kept, known));
    const V count = hn::Max(hn::ConvertTo(d, hn::Neg(sum.less)), set(1));
    const V mean = hn::Div(sum.of_values, count);
    hn::StoreU(hn::IfThenElseZero(kept, mean), d, in.out + x);
    if (in.mean_sigma != nullptr)
      hn::StoreU(hn::Mul(sigma, hn::Div(set(kShared), count)), d, in.mean_sigma + x);
  }
  return dropped;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::nav
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(halve_pixels);
HWY_EXPORT(halve_again);
HWY_EXPORT(keep_pixels);
HWY_EXPORT(smooth_row);

PixelRow pixel_row(const vision::RangeView& view, int y) {
  const std::size_t i = view.index(0, y);
  return {view.depth.data() + i, view.sigma_depth.data() + i,
          view.weight.empty() ? nullptr : view.weight.data() + i};
}

OutRow out_row(InverseDepth& image, int y) { return {image.w.row(y), image.sigma.row(y), image.w.width()}; }

}  // namespace

void DepthReducer::reduce(const vision::RangeView& view, float least_weight, float resolution, int reduction,
                          InverseDepth& out) {
  const int width = view.camera.width, height = view.camera.height;
  const auto near = std::max(static_cast<float>(view.near), 1e-3F);  // what is missing may also read as 0
  nothing_.resize(static_cast<std::size_t>(width), 0.0F);
  const PixelRow nothing{nothing_.data(), nothing_.data(), nothing_.data()};
  const auto rows = [&](int y) -> PixelRows {
    const auto row = [&](int v) { return v < height ? pixel_row(view, v) : nothing; };
    return {row(y), row(y + 1), width, near, least_weight};
  };
  const auto halved = [](int size) { return (size + 1) / 2; };
  if (reduction == 1) {
    out.reset(width, height);
    for (int y = 0; y < height; ++y) HWY_DYNAMIC_DISPATCH(keep_pixels)(rows(y), out_row(out, y));
  } else if (reduction == 2) {
    out.reset(halved(width), halved(height));
    for (int y = 0; y < out.w.height(); ++y)
      HWY_DYNAMIC_DISPATCH(halve_pixels)(rows(2 * y), resolution, out_row(out, y));
  } else {
    out.reset(halved(halved(width)), halved(halved(height)));
    halves_.reset(halved(width), 2);
    for (int y = 0; y < out.w.height(); ++y) {
      for (const int k : {0, 1})
        HWY_DYNAMIC_DISPATCH(halve_pixels)(rows(4 * y + 2 * k), resolution, out_row(halves_, k));
      HWY_DYNAMIC_DISPATCH(halve_again)(halves_, resolution, out_row(out, y));
    }
  }
}

std::size_t smooth(const RingImage<float>& in, const RingImage<float>& sigma, int reach, int supporters,
                   float resolution, RingImage<float>& out, RingImage<float>* mean_sigma) {
  out.reset(in.width(), in.height());
  if (mean_sigma != nullptr) mean_sigma->reset(in.width(), in.height());
  std::size_t dropped = 0;
  for (int y = 0; y < in.height(); ++y) {
    dropped += HWY_DYNAMIC_DISPATCH(smooth_row)({{in.row(y - reach), in.row(y), in.row(y + reach)},
                                                 sigma.row(y),
                                                 reach,
                                                 supporters,
                                                 in.width(),
                                                 resolution,
                                                 out.row(y),
                                                 mean_sigma == nullptr ? nullptr : mean_sigma->row(y)});
  }
  return dropped;
}

}  // namespace headway::nav
#endif
