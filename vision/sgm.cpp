#include "vision/sgm.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace headway::vision {

namespace {

constexpr std::size_t kAlignment = 64;
constexpr std::size_t kBlockBytes = 1'000'000;  // of costs and sums at a time: what a core's own cache holds

std::size_t rounded_up(std::size_t size) { return (size + kAlignment - 1) / kAlignment * kAlignment; }

/// Costs 0 everywhere, between margins that are never the cheapest.
void start_path(const SgmFacts& f, std::uint8_t* state) {
  const auto padded = static_cast<std::size_t>(f.padded);
  for (int x = 0; x < f.width; ++x, state += padded + kStateMargin) {
    std::memset(state, 255, kStateMargin);
    std::memset(state + kStateMargin, 0, padded);
  }
  std::memset(state, 255, kStateMargin);
}

/// Where the minimum lies between the winner and its neighbours, in 1/16 px: two lines of equal and opposite
/// slope through the three sums. Costs of this kind have a pointed minimum, which a parabola would flatten.
int offset_16(int below, int least, int above) {
  const int steeper = std::max(std::max(below, above) - least, 1);
  return static_cast<int>(8.0F * static_cast<float>(below - above) / static_cast<float>(steeper) + 16.5F) -
         16;
}

}  // namespace

void Sgm::prepare(const SgmSearch& s, const SgmPenalties& p) {
  search_ = s;
  SgmFacts& f = facts_;
  f.width = s.width, f.lowest = s.lowest, f.count = s.count, f.padded = padded_count(s.count);
  f.first_column = s.first_column, f.end_column = s.end_column;
  f.p1 = static_cast<std::uint8_t>(p.p1);
  for (int step = -255; step <= 255; ++step)
    f.p2[static_cast<std::size_t>(255 + step)] =
        static_cast<std::uint8_t>(std::max(p.p2_least, p.p2 * p.p2_edge / (p.p2_edge + std::abs(step))));
  kernels_ = sgm_kernels(f.padded);

  const auto width = static_cast<std::size_t>(s.width), padded = static_cast<std::size_t>(f.padded);
  const auto height = static_cast<std::size_t>(s.height);
  const bool both_ways = p.paths == 4;
  const std::size_t rows = both_ways ? std::clamp<std::size_t>(kBlockBytes / (2 * width * padded), 4,
                                                               std::max<std::size_t>(4, height))
                                     : 1;
  block_rows_ = static_cast<int>(rows);
  const std::size_t blocks = both_ways ? (height + rows - 1) / rows : 0;
  const std::size_t state = rounded_up(state_size(f)), volume = rounded_up(rows * width * padded);
  const std::size_t line = rounded_up(width + padded);
  const std::size_t scratch = rounded_up(static_cast<std::size_t>(kScratchRows * scratch_pitch(f)));
  memory_.resize(kAlignment + rounded_up(3 * padded) + (2 + blocks) * state + 2 * volume + 6 * line +
                 scratch);

  std::uint8_t* at =
      memory_.data() + (kAlignment - reinterpret_cast<std::uintptr_t>(memory_.data()) % kAlignment);
  const auto take = [&](std::size_t size) { return std::exchange(at, at + size); };
  std::uint8_t* outside = take(rounded_up(3 * padded));
  std::memset(outside, kOutsideCost, 3 * padded);
  std::memset(outside + padded, 0, padded);
  f.outside = outside, f.scratch = take(scratch);
  down_ = take(state), up_ = take(state), saved_ = take(blocks * state);
  costs_ = take(volume), sums_ = take(volume);
  row_ = {take(line), take(line), take(line), take(line), take(line), take(line) + padded};
}

SgmRowInput Sgm::input(const hal::GrayImage& left, int y, int before) const {
  SgmRowInput row{};
  for (int plane = 0; plane < Census::kPlanes; ++plane) {
    row.left[static_cast<std::size_t>(plane)] = left_.row(plane, y);
    row.right[static_cast<std::size_t>(plane)] = right_.row(plane, y) + (search_.width - 1 + search_.lowest);
  }
  const auto grey = [&](int v) {
    return left.pixels.data() + static_cast<std::ptrdiff_t>(v) * search_.width;
  };
  row.grey = grey(y), row.grey_before = grey(std::clamp(before, 0, search_.height - 1));
  return row;
}

void Sgm::finish_row(int y, SgmResult& result) const {
  // Local, for bytes that are stored may lie anywhere else.
  const SgmRowOutput row = row_;
  const int first = facts_.first_column, end = facts_.end_column, width = facts_.width,
            lowest = facts_.lowest;
  const std::ptrdiff_t start = static_cast<std::ptrdiff_t>(y) * width;
  std::int16_t* disparity = result.disparity.data() + start;
  for (int x = first; x < end; ++x)
    disparity[x] =
        static_cast<std::int16_t>(16 * row.winner[x] + offset_16(row.below[x], row.least[x], row.above[x]));
  std::copy(row.least + first, row.least + end, result.least.data() + start + first);
  std::copy(row.second + first, row.second + end, result.second.data() + start + first);
  std::uint8_t* disagreement = result.disagreement.data() + start;
  for (int x = first; x < end; ++x) {
    const int winner = row.winner[x], partner = x - lowest - winner;
    const bool inside = partner >= 0 && partner < width;
    const int apart = std::abs(row.right_winner[x - winner] - winner);
    disagreement[x] = inside ? static_cast<std::uint8_t>(apart) : SgmResult::kOutside;
  }
  const std::uint8_t* planes = left_.row(0, y);
  const std::ptrdiff_t pitch = left_.pitch();
  for (int x = first; x < end; ++x) {
    std::uint8_t shown = planes[Census::kSlopePlane * pitch + x] ^ Census::kLevel;
    for (int plane = 0; plane < Census::kBitPlanes; ++plane) shown |= planes[plane * pitch + x];
    disagreement[x] = shown ? disagreement[x] : SgmResult::kOutside;
  }
}

void Sgm::sweep_down(const hal::GrayImage& left, SgmResult& result) {
  start_path(facts_, down_);
  for (int y = 0; y < search_.height; ++y) {
    const SgmRowInput row = input(left, y, y - 1);
    kernels_.forward(facts_, row, down_, costs_, sums_);
    kernels_.backward(facts_, row, nullptr, costs_, sums_, row_);
    finish_row(y, result);
  }
}

/// The path from above is needed where the one from below comes by, and keeping it for the whole image would
/// take more time than finding it twice: a first sweep leaves its state before each block of rows, and from
/// there it is found again, block by block upwards.
void Sgm::sweep_both_ways(const hal::GrayImage& left, SgmResult& result) {
  const int rows = block_rows_, blocks = (search_.height + rows - 1) / rows;
  const std::size_t state = rounded_up(state_size(facts_));
  const auto saved = [&](int block) { return saved_ + static_cast<std::size_t>(block) * state; };
  start_path(facts_, saved(0));
  for (int block = 0; block + 1 < blocks; ++block) {
    std::memcpy(saved(block + 1), saved(block), state);
    for (int y = block * rows; y < (block + 1) * rows; ++y)
      kernels_.vertical(facts_, input(left, y, y - 1), saved(block + 1));
  }
  start_path(facts_, up_);
  const std::size_t row_bytes =
      static_cast<std::size_t>(facts_.width) * static_cast<std::size_t>(facts_.padded);
  for (int block = blocks - 1; block >= 0; --block) {
    const int first = block * rows, end = std::min(first + rows, search_.height);
    const auto in_block = [&](std::uint8_t* volume, int y) {
      return volume + static_cast<std::size_t>(y - first) * row_bytes;
    };
    for (int y = first; y < end; ++y)
      kernels_.forward(facts_, input(left, y, y - 1), saved(block), in_block(costs_, y), in_block(sums_, y));
    for (int y = end - 1; y >= first; --y) {
      kernels_.backward(facts_, input(left, y, y + 1), up_, in_block(costs_, y), in_block(sums_, y), row_);
      finish_row(y, result);
    }
  }
}

void Sgm::match(const SgmSearch& search, const SgmPenalties& penalties, const hal::GrayImage& left,
                const hal::GrayImage& right, SgmResult& result) {
  prepare(search, penalties);
  left_.compute(left, false, 0);
  right_.compute(right, true, std::abs(search.lowest) + facts_.padded);
  const std::size_t size = static_cast<std::size_t>(search.width) * static_cast<std::size_t>(search.height);
  result.disparity.assign(size, SgmResult::kNone);
  result.least.assign(size, 255), result.second.assign(size, 255);
  result.disagreement.assign(size, SgmResult::kOutside);
  if (penalties.paths == 4)
    sweep_both_ways(left, result);
  else
    sweep_down(left, result);
}

}  // namespace headway::vision
