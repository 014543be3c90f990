#include "nav/floor_prices.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "hal/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/floor_prices.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace headway::nav::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<std::uint16_t, kChunkCells> d16;
constexpr hn::Rebind<std::uint8_t, decltype(d16)> d8;
using V = hn::Vec<decltype(d16)>;
HWY_INLINE int lanes16() { return static_cast<int>(hn::Lanes(d16)); }
HWY_INLINE V set16(int value) { return hn::Set(d16, static_cast<std::uint16_t>(value)); }

/// A window of columns, row by row from the highest to the lowest. Columns outside the raster hold neither
/// obstacles nor unseen cells.
class PriceRows {
 public:
  PriceRows(const FloorPrices& prices, const GroundRaster& ground, int first_chunk, int last_chunk)
      : prices_(prices),
        ground_(ground),
        first_chunk_(first_chunk),
        last_chunk_(last_chunk),
        margin_((prices.reach() + kChunkCells - 1) / kChunkCells * kChunkCells),
        first_x_(first_chunk * kChunkCells - margin_),
        columns_((last_chunk - first_chunk + 1) * kChunkCells + 2 * margin_) {}

  std::size_t room(int rows) const {
    return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows + 4);
  }

  HWY_INLINE void run(int first_row, int last_row, std::uint16_t* scratch, FloorChunks& into) {
    const auto take = [&scratch, this](int rows) {
      std::uint16_t* taken = scratch;
      scratch += static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns_);
      return taken;
    };
    since_ = take(1), squared_ = take(1), unseen_ = take(1), cells_ = take(1);
    std::uint16_t* below = take(last_row - first_row + 1);
    const int beyond = prices_.range() + 1;
    std::fill_n(since_, columns_, static_cast<std::uint16_t>(beyond));
    for (int y = first_row - prices_.range(); y <= last_row; ++y) {
      if (load(y)) step(beyond);
      if (y >= first_row) std::copy_n(since_, columns_, below + (y - first_row) * columns_);
    }
    std::fill_n(since_, columns_, static_cast<std::uint16_t>(beyond));
    std::fill_n(unseen_, columns_, 0);
    for (int y = last_row - prices_.corridor() + 1; y <= last_row + prices_.corridor(); ++y) count<true>(y);
    for (int y = last_row + prices_.range(); y >= first_row; --y) {
      if (load(y)) step(beyond);
      if (y > last_row) continue;
      count<true>(y - prices_.corridor());
      square(below + (y - first_row) * columns_);
      price(into.row(y));
      count<false>(y + prices_.corridor());
    }
  }

 private:
  /// A row of the raster into cells_; false when it lies outside.
  HWY_INLINE bool load(int y) {
    if (y < 0 || y >= ground_.height) return false;
    const int first = std::max(first_x_, 0), last = std::min(first_x_ + columns_, ground_.width);
    std::fill_n(cells_, first - first_x_, 0);
    const auto* from = reinterpret_cast<const std::uint8_t*>(ground_.row(y));
    std::uint16_t* to = cells_ - first_x_;
    int x = first;
    for (; x + lanes16() <= last; x += lanes16())
      hn::StoreU(hn::PromoteTo(d16, hn::LoadU(d8, from + x)), d16, to + x);
    for (; x < last; ++x) to[x] = from[x];
    std::fill(to + last, cells_ + columns_, 0);
    return true;
  }

  /// How many rows ago there was an obstacle, `beyond` at the most.
  HWY_INLINE void step(int beyond) {
    const V most = set16(beyond), one = set16(1), tight = set16(static_cast<int>(Ground::kTight) - 1);
    for (int x = 0; x < columns_; x += lanes16()) {
      const auto is_obstacle = hn::Gt(hn::LoadU(d16, cells_ + x), tight);
      const V more = hn::Min(hn::Add(hn::LoadU(d16, since_ + x), one), most);
      hn::StoreU(hn::IfThenZeroElse(is_obstacle, more), d16, since_ + x);
    }
  }

  /// Adds the unseen cells of a row to the columns' counts, or takes them away.
  template <bool kAdd>
  HWY_INLINE void count(int y) {
    if (prices_.unseen_prices().back()[1] == 0) return;
    if (y < 0 || y >= ground_.height) return;
    const int first = std::max(first_x_, 0), last = std::min(first_x_ + columns_, ground_.width);
    const auto* from = reinterpret_cast<const std::uint8_t*>(ground_.row(y));
    constexpr auto kUnseen = static_cast<std::uint8_t>(Ground::kUnseen);
    const V unseen = set16(kUnseen), by = set16(kAdd ? 1 : -1);
    std::uint16_t* sums = unseen_ - first_x_;
    int x = first;
    for (; x + lanes16() <= last; x += lanes16()) {
      const auto is_unseen = hn::Eq(hn::PromoteTo(d16, hn::LoadU(d8, from + x)), unseen);
      hn::StoreU(hn::Add(hn::LoadU(d16, sums + x), hn::IfThenElseZero(is_unseen, by)), d16, sums + x);
    }
    for (; x < last; ++x)
      sums[x] = static_cast<std::uint16_t>(sums[x] + (from[x] == kUnseen ? (kAdd ? 1 : -1) : 0));
  }

  HWY_INLINE void square(const std::uint16_t* below) {
    for (int x = 0; x < columns_; x += lanes16()) {
      const V nearest = hn::Min(hn::LoadU(d16, since_ + x), hn::LoadU(d16, below + x));
      hn::StoreU(hn::Mul(nearest, nearest), d16, squared_ + x);
    }
  }

  HWY_INLINE void price(FloorChunk* row) const {
    for (int chunk = first_chunk_; chunk <= last_chunk_; ++chunk) {
      const int x = margin_ + (chunk - first_chunk_) * kChunkCells;
      std::uint16_t distance2[kChunkCells], count[kChunkCells];
      const bool is_near = measure(x, distance2), is_unseen = count_around(x, count);
      auto& price = row[chunk].price;
      if (!is_near && !is_unseen) {
        for (auto& p : price) p.fill(0);
        continue;
      }
      for (std::size_t i = 0; i < kChunkCells; ++i) {
        const FloorPrices::Prices &near = prices_.near_prices()[distance2[i]],
                                  &unseen = prices_.unseen_prices()[count[i]];
        price[0][i] = sum(near[0], unseen[0]);
        price[1][i] = sum(near[1], unseen[1]);
      }
    }
  }

  /// Squared distances to the nearest obstacle; false when all are out of range.
  HWY_INLINE bool measure(int x, std::uint16_t* distance2) const {
    const int range = prices_.range();
    const V beyond = set16((range + 1) * (range + 1));
    V least = beyond;
    for (int dx = -margin_; dx < kChunkCells + margin_; dx += lanes16())
      least = hn::Min(least, hn::LoadU(d16, squared_ + x + dx));
    if (hn::AllTrue(d16, hn::Eq(least, beyond))) {
      std::fill_n(distance2, kChunkCells, static_cast<std::uint16_t>((range + 1) * (range + 1)));
      return false;
    }
    for (int i = 0; i < kChunkCells; i += lanes16()) {
      V best = beyond;
      for (int dx = -range; dx <= range; ++dx)
        best = hn::Min(best, hn::SaturatedAdd(hn::LoadU(d16, squared_ + x + i + dx), set16(dx * dx)));
      hn::StoreU(best, d16, distance2 + i);
    }
    return true;
  }

  /// Unseen cells in the square around each; false when there are none.
  HWY_INLINE bool count_around(int x, std::uint16_t* count) const {
    const int corridor = prices_.corridor();
    V any = hn::Zero(d16);
    for (int i = 0; i < kChunkCells; i += lanes16()) {
      V sum = hn::Zero(d16);
      for (int dx = -corridor; dx <= corridor; ++dx) sum = hn::Add(sum, hn::LoadU(d16, unseen_ + x + i + dx));
      hn::StoreU(sum, d16, count + i);
      any = hn::Or(any, sum);
    }
    return !hn::AllTrue(d16, hn::Eq(any, hn::Zero(d16)));
  }

  const FloorPrices& prices_;
  const GroundRaster& ground_;
  int first_chunk_, last_chunk_;
  int margin_, first_x_, columns_;
  std::uint16_t *since_ = nullptr, *squared_ = nullptr, *unseen_ = nullptr, *cells_ = nullptr;  // [column]
};

void price_rows(const FloorPrices& prices, const GroundRaster& ground, const int (&rows)[2],
                const int (&chunks)[2], std::vector<std::uint16_t>& scratch, FloorChunks& into) {
  PriceRows work(prices, ground, chunks[0], chunks[1]);
  const std::size_t room = work.room(rows[1] - rows[0] + 1);
  if (scratch.size() < room) scratch.resize(room);
  work.run(rows[0], rows[1], scratch.data(), into);
}

}  // namespace
}  // namespace headway::nav::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(price_rows);

constexpr int kFarthest = 250;  // cells; its square still fits 16 bits
constexpr int kStrip = 64;      // rows priced together: bounds the memory needed

int whole_cells(double length, double resolution) {
  return static_cast<int>(std::floor(length / resolution + 1e-9));
}

}  // namespace

FloorPrices::FloorPrices(const PlannerConfig& config, const GaitLimits& gait, double resolution, double tick)
    : range_(whole_cells(config.near_range, resolution)),
      corridor_(whole_cells(config.corridor, resolution)),
      low_(in_ticks(gait.over.cost, tick)) {
  if (range_ > kFarthest || corridor_ > kFarthest / 2) {
    const bool range = range_ > kFarthest;
    throw InputError(std::string("planner: ") + (range ? "near_range" : "corridor") + ": spans " +
                     std::to_string(range ? range_ : corridor_) + " cells, expected at most " +
                     std::to_string(range ? kFarthest : kFarthest / 2));
  }
  const double straight = gait.forward_seconds(resolution), diagonal = std::numbers::sqrt2 * straight;
  const auto prices = [&](double share) -> Prices {
    return {in_ticks(share * straight, tick), in_ticks(share * diagonal, tick)};
  };
  const int beyond = (range_ + 1) * (range_ + 1);
  for (int d2 = 0; d2 <= beyond; ++d2) {
    const double far = std::sqrt(d2) * resolution / std::max(config.near_range, 1e-9);
    near_prices_.push_back(prices(d2 == beyond ? 0 : config.near_price * std::max(0.0, 1 - far)));
  }
  const int square = (2 * corridor_ + 1) * (2 * corridor_ + 1);
  for (int count = 0; count <= square; ++count)
    unseen_prices_.push_back(prices(config.unseen_price * count / square));
}

void FloorPrices::compute(const GroundRaster& ground, int first_row, int last_row, int first_chunk,
                          int last_chunk, FloorChunks& into) {
  for (int y = first_row; y <= last_row; y += kStrip) {
    const int rows[] = {y, std::min(y + kStrip - 1, last_row)}, chunks[] = {first_chunk, last_chunk};
    HWY_DYNAMIC_DISPATCH(price_rows)(*this, ground, rows, chunks, scratch_, into);
  }
}

Ticks FloorPrices::unseen(const GroundRaster& ground, int x, int y, bool diagonal) const {
  std::size_t count = 0;
  for (int row = std::max(0, y - corridor_); row <= std::min(ground.height - 1, y + corridor_); ++row) {
    const Ground* cells = ground.row(row);
    for (int i = std::max(0, x - corridor_); i <= std::min(ground.width - 1, x + corridor_); ++i)
      count += cells[i] == Ground::kUnseen;
  }
  return unseen_prices_[count][diagonal ? 1 : 0];
}

}  // namespace headway::nav
#endif
