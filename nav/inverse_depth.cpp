#include "nav/inverse_depth.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/inverse_depth.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set. Only exact operations are used (no
// approximate reciprocals, no fused sums), so that all of them give the same bytes.
HWY_BEFORE_NAMESPACE();
namespace headway::nav {

#ifndef HEADWAY_DEPTH_ROWS
#define HEADWAY_DEPTH_ROWS
namespace {

// Values of one pixel differ by the noise of two, so that pixels of a block may lie farther apart than means.
constexpr float kPixelSigmas = 7, kMeanSigmas = 4;
constexpr std::ptrdiff_t kRowsAhead = 4;  // fetched: a view does not fit into the nearest caches
constexpr int kLine = 16;                 // floats that are fetched together
constexpr float kHorizon = 16;            // times the view's far: what is farther counts as unknown
constexpr float kShared = 9;              // samples of one mean, away from edges
constexpr int kAround = 6;                // of the neighbours lie on one surface around a hole in it

struct PixelRow {
  const float *depth, *sigma, *weight;  // weight may be null
};

struct PixelRows {
  PixelRow upper, lower;
  int width;
  float near, horizon, least_weight;
};

struct OutRow {
  float *value, *sigma;
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

struct HoleRows {
  const float *w[3], *sigma[3];  // above, here, below
  int width;
  float resolution;
  float *out, *sigma_out, *mean_sigma;
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

/// How much nearer than the horizon points are, zero or less where nothing is known, and the standard
/// deviations of their depths [m].
struct Sample {
  V nearness, sigma;
};

/// A pixel whose sigma exceeds its depth, or is not a number, tells nothing.
template <bool kWhole>
HWY_INLINE Sample pixels(const PixelRows& in, const PixelRow& row, int x) {
  const V depth = load<kWhole>(row.depth, x, in.width), sigma = load<kWhole>(row.sigma, x, in.width);
  auto known = hn::And(hn::Ge(depth, set(in.near)), hn::Lt(sigma, depth));
  if (row.weight != nullptr)
    known = hn::And(known, hn::Ge(load<kWhole>(row.weight, x, in.width), set(in.least_weight)));
  return {hn::IfThenElseZero(known, hn::Sub(set(in.horizon), depth)), hn::IfThenElseZero(known, sigma)};
}

/// -1 where the mask is true, to count with.
HWY_INLINE hn::Vec<decltype(di)> one_less(hn::Mask<D> mask) {
  return hn::VecFromMask(di, hn::RebindMask(di, mask));
}

HWY_INLINE void add_if(hn::Mask<D> in, const Sample& p, Sample& sum, hn::Vec<decltype(di)>& less) {
  sum.nearness = hn::Add(sum.nearness, hn::IfThenElseZero(in, p.nearness));
  sum.sigma = hn::Add(sum.sigma, hn::IfThenElseZero(in, p.sigma));
  less = hn::Add(less, one_less(in));
}

/// The mean of those of four that lie on one surface, two or more, with the mean of their sigmas: about the
/// second nearest, for the nearest may be wrong. Zero without them.
HWY_INLINE Sample near_pair(const Sample& p0, const Sample& p1, const Sample& p2, const Sample& p3,
                            float resolution) {
  const V a = hn::Max(p0.nearness, p1.nearness), b = hn::Min(p0.nearness, p1.nearness),
          e = hn::Max(p2.nearness, p3.nearness), f = hn::Min(p2.nearness, p3.nearness);
  const V second = hn::Max(hn::Min(a, e), hn::Max(b, f));
  const V widest = hn::Max(hn::Max(p0.sigma, p1.sigma), hn::Max(p2.sigma, p3.sigma));
  const V apart = hn::Max(hn::Mul(set(kPixelSigmas), widest), set(resolution));
  Sample sum{hn::Zero(d), hn::Zero(d)};
  auto less = hn::Zero(di);
  const auto add_near = [&](const Sample& p) HWY_ATTR {
    add_if(hn::Le(hn::Abs(hn::Sub(p.nearness, second)), apart), p, sum, less);
  };
  add_near(p0), add_near(p1), add_near(p2), add_near(p3);
  const auto known = hn::And(hn::Gt(second, hn::Zero(d)), hn::RebindMask(d, hn::Gt(hn::Set(di, -1), less)));
  const V share = hn::IfThenElseZero(known, hn::Div(set(-1), hn::ConvertTo(d, less)));
  return {hn::Mul(sum.nearness, share), hn::Mul(sum.sigma, share)};
}

/// The mean of two that were halved before and lie on one surface, else the nearer.
HWY_INLINE Sample nearer_or_mean(const Sample& p, const Sample& q, float resolution) {
  const V apart = hn::Max(hn::Mul(set(kMeanSigmas), hn::Max(p.sigma, q.sigma)), set(resolution));
  const auto same = hn::And(hn::Gt(hn::Min(p.nearness, q.nearness), hn::Zero(d)),
                            hn::Le(hn::Abs(hn::Sub(p.nearness, q.nearness)), apart));
  const V half = set(0.5F);
  const auto first = hn::Ge(p.nearness, q.nearness);
  return {
      hn::IfThenElse(same, hn::Mul(hn::Add(p.nearness, q.nearness), half), hn::Max(p.nearness, q.nearness)),
      hn::IfThenElse(same, hn::Mul(hn::Add(p.sigma, q.sigma), half),
                     hn::IfThenElse(first, p.sigma, q.sigma))};
}

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE V even(V a, V) { return a; }
HWY_INLINE V odd(V, V b) { return b; }
HWY_INLINE V in_order(V v) { return v; }
#else
// Pairs of neighbours from two vectors, those of the second between those of the first; and, of what was made
// of such pairs, back to their order.
HWY_INLINE V even(V a, V b) { return hn::OddEven(hn::DupEven(b), a); }
HWY_INLINE V odd(V a, V b) { return hn::OddEven(b, hn::DupOdd(a)); }
HWY_INLINE V in_order(V v) {
  constexpr int kMost = HWY_MAX_BYTES / sizeof(float);
  HWY_ALIGN std::int32_t from[kMost];
  for (int i = 0; i < lanes(); ++i) from[i] = i < lanes() / 2 ? 2 * i : 2 * i + 1 - lanes();
  return hn::TableLookupLanes(v, hn::SetTableIndices(d, from));
}
#endif

HWY_INLINE Sample evens(const Sample& a, const Sample& b) {
  return {even(a.nearness, b.nearness), even(a.sigma, b.sigma)};
}
HWY_INLINE Sample odds(const Sample& a, const Sample& b) {
  return {odd(a.nearness, b.nearness), odd(a.sigma, b.sigma)};
}

/// Fetches what two vectors from x on of a row some rows below hold.
HWY_INLINE void fetch_ahead(const PixelRow& row, int x, int width) {
  for (int i = x; i < x + 2 * lanes(); i += kLine) {
    hwy::Prefetch(row.depth + i + kRowsAhead * width);
    hwy::Prefetch(row.sigma + i + kRowsAhead * width);
  }
}

template <bool kWhole>
HWY_INLINE Sample halved_pixels(const PixelRows& in, float resolution, int x) {
  if (kWhole) {
    fetch_ahead(in.upper, 2 * x, in.width);
    fetch_ahead(in.lower, 2 * x, in.width);
  }
  const Sample al = pixels<kWhole>(in, in.upper, 2 * x), ar = pixels<kWhole>(in, in.upper, 2 * x + lanes()),
               bl = pixels<kWhole>(in, in.lower, 2 * x), br = pixels<kWhole>(in, in.lower, 2 * x + lanes());
  const Sample mean = near_pair(evens(al, ar), odds(al, ar), evens(bl, br), odds(bl, br), resolution);
  return {in_order(mean.nearness), in_order(mean.sigma)};
}

/// As inverse depth.
HWY_INLINE Sample inverse(const Sample& p, float horizon) {
  const auto known = hn::Gt(p.nearness, hn::Zero(d));
  const V w = hn::IfThenElseZero(known, hn::Div(set(1), hn::Sub(set(horizon), p.nearness)));
  return {w, hn::Mul(p.sigma, hn::Mul(w, w))};
}

HWY_INLINE void store(const OutRow& out, int x, const Sample& p) {
  hn::StoreU(p.nearness, d, out.value + x);
  hn::StoreU(p.sigma, d, out.sigma + x);
}

/// Zeros behind the row's last.
HWY_INLINE void store_last(const OutRow& out, int x, const Sample& p) {
  const auto inside = hn::FirstN(d, static_cast<std::size_t>(out.width - x));
  store(out, x, {hn::IfThenElseZero(inside, p.nearness), hn::IfThenElseZero(inside, p.sigma)});
}

template <class Finish>
HWY_INLINE void halve_pixels(const PixelRows& in, float resolution, const OutRow& out, const Finish& finish) {
  int x = 0;
  for (; 2 * (x + lanes()) <= in.width; x += lanes())
    store(out, x, finish(halved_pixels<true>(in, resolution, x)));
  if (x > 0 && x < out.width && in.width % 2 == 0) {
    // Some samples once more are quicker than the rest of a vector pixel by pixel.
    x = out.width - lanes();
    store(out, x, finish(halved_pixels<true>(in, resolution, x)));
    return;
  }
  for (; x < out.width; x += lanes()) store_last(out, x, finish(halved_pixels<false>(in, resolution, x)));
}

/// To inverse depth.
void halve_once(const PixelRows& in, float resolution, const OutRow& out) {
  halve_pixels(in, resolution, out, [&](const Sample& p) HWY_ATTR { return inverse(p, in.horizon); });
}

/// To nearness.
void halve_first(const PixelRows& in, float resolution, const OutRow& out) {
  halve_pixels(in, resolution, out, [](const Sample& p) HWY_ATTR { return p; });
}

/// From a row of nearness to inverse depth.
void halve_second(const OutRow& in, float horizon, float resolution, const OutRow& out) {
  for (int x = 0; x < out.width; x += lanes()) {
    const auto at = [&in](int i) HWY_ATTR -> Sample {
      return {hn::LoadU(d, in.value + i), hn::LoadU(d, in.sigma + i)};
    };
    const Sample left = at(2 * x), right = at(2 * x + lanes());
    const Sample mean = nearer_or_mean(evens(left, right), odds(left, right), resolution);
    store_last(out, x, inverse({in_order(mean.nearness), in_order(mean.sigma)}, horizon));
  }
}

void keep_pixels(const PixelRows& in, const OutRow& out) {
  for (int x = 0; x < out.width; x += lanes())
    store_last(out, x, inverse(pixels<false>(in, in.upper, x), in.horizon));
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

/// Gives samples of which nothing is known the surface of their neighbours, where at least six of eight lie
/// on one.
void fill_row(const HoleRows& in) {
  for (int x = 0; x < in.width; x += lanes()) {
    const auto inside = hn::FirstN(d, static_cast<std::size_t>(in.width - x));
    const auto hole = hn::And(inside, hn::Le(hn::LoadU(d, in.w[1] + x), set(kLeastKnown)));
    if (hn::AllFalse(d, hole)) continue;
    const auto for_each_neighbour = [&](const auto& visit) HWY_ATTR {
      for (int row = 0; row < 3; ++row) {
        for (int i = -1; i <= 1; ++i) {
          if (row == 1 && i == 0) continue;
          const V w = hn::LoadU(d, in.w[row] + x + i), sigma = hn::LoadU(d, in.sigma[row] + x + i);
          visit(w, hn::IfThenElseZero(hn::Gt(w, set(kLeastKnown)), sigma));  // it may have been filled by now
        }
      }
    };
    V nearest = hn::Zero(d), widest = nearest;
    for_each_neighbour([&](V w, V sigma) HWY_ATTR {
      nearest = hn::Max(nearest, w);
      widest = hn::Max(widest, sigma);
    });
    const V apart =
        hn::Max(hn::Mul(set(kMeanSigmas), widest), hn::Mul(set(in.resolution), hn::Mul(nearest, nearest)));
    const V low = hn::Max(hn::Sub(nearest, apart), set(kLeastKnown));
    Sample sum{hn::Zero(d), hn::Zero(d)};
    auto less = hn::Zero(di);
    for_each_neighbour([&](V w, V sigma) HWY_ATTR { add_if(hn::Ge(w, low), {w, sigma}, sum, less); });
    const auto filled = hn::And(hole, hn::RebindMask(d, hn::Gt(hn::Set(di, 1 - kAround), less)));
    const V share = hn::Div(set(1), hn::Max(hn::ConvertTo(d, hn::Neg(less)), set(1)));
    const auto put = [&](V value, float* row) HWY_ATTR {
      hn::StoreU(hn::IfThenElse(filled, value, hn::LoadU(d, row + x)), d, row + x);
    };
    const V sigma = hn::Mul(sum.sigma, share);
    put(hn::Mul(sum.nearness, share), in.out);
    put(sigma, in.sigma_out);
    put(hn::Mul(sigma, hn::Mul(set(kShared), share)), in.mean_sigma);
  }
}

std::size_t smooth_row(const MeanRows& in) {
  std::size_t dropped = 0;
  const auto too_few = hn::Set(di, -in.supporters);
  for (int x = 0; x < in.width; x += lanes()) {
    const V w = hn::LoadU(d, in.rows[1] + x), sigma = hn::LoadU(d, in.sigma + x);
    const V apart = hn::Max(hn::Mul(set(kMeanSigmas), sigma), hn::Mul(set(in.resolution), hn::Mul(w, w)));
    const V low = hn::Max(hn::Sub(w, apart), set(kLeastKnown)), high = hn::Add(w, apart);
    Sum sum{hn::Zero(d), hn::Zero(di)};
    add_row(in.rows[0] + x, in.reach, low, high, sum);
    add_row(in.rows[1] + x, in.reach, low, high, sum);
    add_row(in.rows[2] + x, in.reach, low, high, sum);
    const auto known = hn::Gt(w, set(kLeastKnown));
    const auto kept = hn::And(known, hn::RebindMask(d, hn::Gt(too_few, sum.less)));
    dropped += hn::CountTrue(d, hn::AndNot(kept, known));
    const V share = hn::Div(set(1), hn::Max(hn::ConvertTo(d, hn::Neg(sum.less)), set(1)));
    hn::StoreU(hn::IfThenElseZero(kept, hn::Mul(sum.of_values, share)), d, in.out + x);
    if (in.mean_sigma != nullptr)
      hn::StoreU(hn::Mul(sigma, hn::Mul(set(kShared), share)), d, in.mean_sigma + x);
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

HWY_EXPORT(halve_once);
HWY_EXPORT(halve_first);
HWY_EXPORT(halve_second);
HWY_EXPORT(keep_pixels);
HWY_EXPORT(fill_row);
HWY_EXPORT(smooth_row);

PixelRow pixel_row(const vision::RangeView& view, int y) {
  const std::size_t i = view.index(0, y);
  return {view.depth.data() + i, view.sigma_depth.data() + i,
          view.weight.empty() ? nullptr : view.weight.data() + i};
}

OutRow out_row(InverseDepth& image, int y) { return {image.w.row(y), image.sigma.row(y), image.w.width()}; }

}  // namespace

void DepthReducer::reduce(const vision::RangeView& view, float least_weight, float resolution,
                          Reduction reduction, InverseDepth& out) {
  const int width = view.camera.width, height = view.camera.height;
  const auto near = std::max(static_cast<float>(view.near), 1e-3F);  // what is missing may also read as 0
  const float horizon = kHorizon * static_cast<float>(view.far);
  nothing_.resize(static_cast<std::size_t>(width), 0.0F);
  const PixelRow nothing{nothing_.data(), nothing_.data(), nothing_.data()};
  const auto rows = [&](int upper, int lower) -> PixelRows {
    const auto row = [&](int v) { return v < height ? pixel_row(view, v) : nothing; };
    return {row(upper), row(lower), width, near, horizon, least_weight};
  };
  const auto halved = [](int size) { return (size + 1) / 2; };
  if (reduction.times == 1) {
    out.reset(width, height);
    for (int y = 0; y < height; ++y) HWY_DYNAMIC_DISPATCH(keep_pixels)(rows(y, y), out_row(out, y));
  } else if (reduction.times == 2) {
    out.reset(halved(width), halved(height));
    for (int y = 0; y < out.w.height(); ++y)
      HWY_DYNAMIC_DISPATCH(halve_once)(rows(2 * y, 2 * y + 1), resolution, out_row(out, y));
  } else {
    out.reset(halved(halved(width)), halved(halved(height)));
    half_.nearness.reset(halved(width), 1);
    half_.sigma.reset(halved(width), 1);
    const OutRow half{half_.nearness.row(0), half_.sigma.row(0), half_.nearness.width()};
    const int upper = reduction.rows == RowsRead::kInner ? 1 : 0, lower = 3 - upper;
    for (int y = 0; y < out.w.height(); ++y) {
      HWY_DYNAMIC_DISPATCH(halve_first)(rows(4 * y + upper, 4 * y + lower), resolution, half);
      HWY_DYNAMIC_DISPATCH(halve_second)(half, horizon, resolution, out_row(out, y));
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

void fill_holes(InverseDepth& rough, float resolution, RingImage<float>& smooth_w,
                RingImage<float>& mean_sigma) {
  RingImage<float>&w = rough.w, &sigma = rough.sigma;
  for (int y = 0; y < w.height(); ++y) {
    HWY_DYNAMIC_DISPATCH(fill_row)
    ({{w.row(y - 1), w.row(y), w.row(y + 1)},
      {sigma.row(y - 1), sigma.row(y), sigma.row(y + 1)},
      w.width(),
      resolution,
      smooth_w.row(y),
      sigma.row(y),
      mean_sigma.row(y)});
  }
}

}  // namespace headway::nav
#endif
