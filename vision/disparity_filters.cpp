#include "vision/disparity_filters.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/disparity_filters.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace headway::vision::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

template <class V>
struct Sorted {
  V low, middle, high;
};

template <class V>
HWY_INLINE Sorted<V> sorted(V a, V b, V c) {
  const V low = hn::Min(a, b), high = hn::Max(a, b);
  return {hn::Min(low, c), hn::Max(low, hn::Min(high, c)), hn::Max(high, c)};
}

/// Medians of as many neighbouring pixels as D has lanes. Of nine numbers in three sorted columns the median
/// is that of the highest low, the middle middle and the lowest high one.
template <class D>
HWY_INLINE void medians(D d, const std::int16_t* const* rows, int x, std::int16_t* out) {
  const auto column = [&](int at) HWY_ATTR {
    return sorted(hn::LoadU(d, rows[0] + at), hn::LoadU(d, rows[1] + at), hn::LoadU(d, rows[2] + at));
  };
  const auto a = column(x - 1), b = column(x), c = column(x + 1);
  const auto low = hn::Max(hn::Max(a.low, b.low), c.low), high = hn::Min(hn::Min(a.high, b.high), c.high);
  hn::StoreU(sorted(low, sorted(a.middle, b.middle, c.middle).middle, high).middle, d, out + x);
}

}  // namespace

void MedianRow(const std::int16_t* const* rows, int width, std::int16_t* out) {
  const hn::ScalableTag<std::int16_t> d;
  const hn::CappedTag<std::int16_t, 1> one;
  const int lanes = static_cast<int>(hn::Lanes(d));
  out[0] = rows[1][0], out[width - 1] = rows[1][width - 1];
  int x = 1;
  for (; x + lanes <= width - 1; x += lanes) medians(d, rows, x, out);
  for (; x < width - 1; ++x) medians(one, rows, x, out);
}

}  // namespace headway::vision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {

namespace {
HWY_EXPORT(MedianRow);
}

void median_3x3(int width, int height, const std::int16_t* in, std::int16_t* out) {
  const auto row = [&](int y) {
    return in + static_cast<std::ptrdiff_t>(std::clamp(y, 0, height - 1)) * width;
  };
  for (int y = 0; y < height; ++y) {
    const std::int16_t* rows[] = {row(y - 1), row(y), row(y + 1)};
    HWY_DYNAMIC_DISPATCH(MedianRow)(rows, width, out + static_cast<std::ptrdiff_t>(y) * width);
  }
}

int SpeckleFilter::root(int run) {
  const auto at = [&](int i) -> Run& { return runs_[static_cast<std::size_t>(i)]; };
  while (at(run).patch != run) run = at(run).patch = at(at(run).patch).patch;
  return run;
}

void SpeckleFilter::join(int one, int other) {
  one = root(one), other = root(other);
  if (one == other) return;
  if (one > other) std::swap(one, other);
  runs_[static_cast<std::size_t>(other)].patch = one;
  runs_[static_cast<std::size_t>(one)].size += runs_[static_cast<std::size_t>(other)].size;
}

int SpeckleFilter::add_runs(const std::int16_t* row, int width, int step) {
  for (int x = 0; x < width;) {
    const int begin = x++;
    if (row[begin] < 0) continue;
    while (x < width && row[x] >= 0 && std::abs(row[x] - row[x - 1]) <= step) ++x;
    runs_.push_back({begin, x, static_cast<int>(runs_.size()), x - begin});
  }
  return static_cast<int>(runs_.size());
}

/// Joins the runs `above` to `middle` of one row with those from there to `end` of the next, `row`.
void SpeckleFilter::join_rows(int above, int middle, int end, const std::int16_t* row, int width, int step) {
  for (int i = above, j = middle; i < middle && j < end;) {
    const Run &a = runs_[static_cast<std::size_t>(i)], &b = runs_[static_cast<std::size_t>(j)];
    const int last = std::min(a.end, b.end);
    for (int x = std::max(a.begin, b.begin); x < last; ++x)
      if (std::abs(row[x] - row[x - width]) <= step) {
        join(i, j);
        break;
      }
    a.end < b.end ? ++i : ++j;
  }
}

void SpeckleFilter::drop(int width, int height, int largest, int step, std::int16_t none,
                         std::int16_t* disparity) {
  const auto row = [&](int y) { return disparity + static_cast<std::ptrdiff_t>(y) * width; };
  runs_.clear(), first_run_.clear();
  runs_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  first_run_.reserve(static_cast<std::size_t>(height) + 1);
  for (int y = 0; y < height; ++y) {
    const int middle = static_cast<int>(runs_.size()), end = add_runs(row(y), width, step);
    if (y > 0) join_rows(first_run_.back(), middle, end, row(y), width, step);
    first_run_.push_back(middle);
  }
  first_run_.push_back(static_cast<int>(runs_.size()));
  for (int y = 0; y < height; ++y)
    for (int i = first_run_[static_cast<std::size_t>(y)]; i < first_run_[static_cast<std::size_t>(y) + 1];
         ++i) {
      const Run& run = runs_[static_cast<std::size_t>(i)];
      if (runs_[static_cast<std::size_t>(root(i))].size <= largest)
        std::fill(row(y) + run.begin, row(y) + run.end, none);
    }
}

}  // namespace headway::vision
#endif
