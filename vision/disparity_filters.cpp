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

/// Medians of as many neighbouring pixels as D has lanes: the exchanges that bring the middle of nine to its
/// place (N. Devillard, "Fast median search", 1998).
template <class D>
HWY_INLINE void medians(D d, const std::int16_t* const* rows, int x, std::int16_t* out) {
  static constexpr int kExchanges[19][2] = {{1, 2}, {4, 5}, {7, 8}, {0, 1}, {3, 4}, {6, 7}, {1, 2},
                                            {4, 5}, {7, 8}, {0, 3}, {5, 8}, {4, 7}, {3, 6}, {1, 4},
                                            {2, 5}, {4, 7}, {4, 2}, {6, 4}, {4, 2}};
  hn::Vec<D> v[9];
  for (int i = 0; i < 9; ++i) v[i] = hn::LoadU(d, rows[i / 3] + x + i % 3 - 1);
  for (const auto& [a, b] : kExchanges) {
    const auto lower = hn::Min(v[a], v[b]);
    v[b] = hn::Max(v[a], v[b]);
    v[a] = lower;
  }
  hn::StoreU(v[4], d, out + x);
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
