#include "nav/sample_errors.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "nav/inverse_depth.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/sample_errors.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set. Only exact operations are used (no
// approximate reciprocals, no fused sums), so that all of them give the same bytes.
HWY_BEFORE_NAMESPACE();
namespace headway::nav {

#ifndef HEADWAY_SAMPLE_ERRORS
#define HEADWAY_SAMPLE_ERRORS
namespace {

constexpr float kLeastSigma = 1e-30F;  // [1/m], to divide by
constexpr int kBins = 256;             // of one sigma
constexpr int kMostSigmas = 2;         // of a second difference; what differs by more is another surface
constexpr float kSecondDifference = 2.449490F;  // sqrt(1 + 4 + 1): its sigma beside a sample's

constexpr int kAllBins = kMostSigmas * kBins;
/// How many second differences lie in each bin; in the last, those that do not count.
using Histogram = std::array<std::uint32_t, kAllBins + 1>;

struct SampleTriples {
  const float *before, *here, *after, *sigma;
  int count;
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

void count_triples(const SampleTriples& in, Histogram& histogram) {
  constexpr std::size_t kMost = HWY_MAX_BYTES / sizeof(float);
  const auto lanes = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN std::int32_t bins[kMost];
  for (int x = 0; x < in.count; x += lanes) {
    const V left = hn::LoadU(d, in.before + x), here = hn::LoadU(d, in.here + x),
            right = hn::LoadU(d, in.after + x), sigma = hn::LoadU(d, in.sigma + x);
    const auto known = hn::And(hn::Gt(hn::Min(hn::Min(left, here), right), hn::Set(d, kLeastKnown)),
                               hn::Gt(sigma, hn::Zero(d)));
    const V bend = hn::Abs(hn::Sub(hn::Add(left, right), hn::Add(here, here)));
    const V bin = hn::Div(hn::Mul(bend, hn::Set(d, kBins / kSecondDifference)),
                          hn::Max(sigma, hn::Set(d, kLeastSigma)));
    const V end = hn::Set(d, kAllBins);
    hn::Store(hn::ConvertTo(di, hn::IfThenElse(known, hn::Min(bin, end), end)), di, bins);
    for (int i = 0; i < lanes; ++i) ++histogram[static_cast<std::size_t>(bins[i])];
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::nav
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(count_triples);

constexpr int kRows = 30;               // are looked at, about
constexpr std::uint32_t kFewest = 200;  // second differences
constexpr double kQuantile = 0.25;
constexpr double kSigmaOfQuantile = 3.1383;  // of a Gaussian's absolute values

/// In bins, as if each of them were evenly filled.
double quantile_of(const Histogram& histogram, std::uint32_t known) {
  std::uint32_t below = 0;
  std::size_t bin = 0;
  while (below + histogram[bin] < kQuantile * known) below += histogram[bin++];
  return static_cast<double>(bin) + (kQuantile * known - below) / histogram[bin];
}

double errors_of(const Histogram& histogram) {
  std::uint32_t known = 0;
  for (std::size_t bin = 0; bin < kAllBins; ++bin) known += histogram[bin];
  if (known < kFewest) return 0;
  return std::min(1.0, kSigmaOfQuantile * quantile_of(histogram, known) / kBins);
}

}  // namespace

double sample_errors(const RingImage<float>& w, const RingImage<float>& sigma, int apart) {
  Histogram across{}, down{};
  const auto count = [](const SampleTriples& triples, Histogram& histogram) {
    HWY_DYNAMIC_DISPATCH(count_triples)(triples, histogram);
  };
  const int rows_apart = std::max(1, w.height() / kRows);
  for (int y = 0; y < w.height(); y += rows_apart) {
    const float* here = w.row(y) + apart;
    count({here - apart, here, here + apart, sigma.row(y) + apart, w.width() - 2 * apart}, across);
    if (y >= apart && y + apart < w.height())
      count({w.row(y - apart), w.row(y), w.row(y + apart), sigma.row(y), w.width()}, down);
  }
  return std::min(errors_of(across), errors_of(down));
}

}  // namespace headway::nav
#endif
