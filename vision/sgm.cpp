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
  if (s == search_ && p == penalties_ && !memory_.empty()) return;
  search_ = s, penalties_ = p;
  SgmFacts& f = facts_;
  f.width = s.width, f.lowest = s.lowest, f.count = s.count, f.padded = padded_count(s.count);
  f.first_column = s.first_column, f.end_column = s.end_column;
  f.p1 = static_cast<std::uint8_t>(p.p1);
  for (int step = -255; step <= 255; ++step)
    f.p2[static_cast<std::size_t>(255 + step)] =
        static_cast<std::uint8_t>(std::max(p.p2_least, p.p2 * p.p2_edge / (p.p2_edge + std::abs(step))));
  kernels_ = sgm_kernels(f.padded);
  take_memory();
}

void Sgm::take_memory() {
  const auto width = static_cast<std::size_t>(facts_.width), padded = static_cast<std::size_t>(facts_.padded);
  const int height = search_.height, above = penalties_.paths == 4 ? height / 2 : height;
  block_rows_ = penalties_.paths == 4 ? std::max(4, static_cast<int>(kBlockBytes / (2 * width * padded))) : 1;
  halves_[0] = {0, 1, above, 0, {}, nullptr, nullptr, nullptr, {}};
  halves_[1] = {height - 1, -1, height - above, 0, {}, nullptr, nullptr, nullptr, {}};
  const std::size_t state = rounded_up(state_size(facts_));
  const std::size_t volume = rounded_up(static_cast<std::size_t>(block_rows_) * width * padded);
  const std::size_t line = rounded_up(width + padded), outside_size = rounded_up(3 * padded);
  const std::size_t scratch = rounded_up(static_cast<std::size_t>(kScratchRows * scratch_pitch(facts_)));
  std::size_t states = 0;
  for (Half& half : halves_) {
    half.blocks = penalties_.paths == 4 ? (half.rows + block_rows_ - 1) / block_rows_ : 0;
    states += static_cast<std::size_t>(half.blocks) + 1;
  }
  memory_.resize(kAlignment + outside_size + states * state + 2 * (2 * volume + 6 * line + scratch));
  std::uint8_t* at =
      memory_.data() + (kAlignment - reinterpret_cast<std::uintptr_t>(memory_.data()) % kAlignment);
  const auto take = [&](std::size_t size) { return std::exchange(at, at + size); };
  std::uint8_t* outside = take(outside_size);
  std::memset(outside, kOutsideCost, 3 * padded);
  std::memset(outside + padded, 0, padded);
  facts_.outside = outside;
  for (Half& half : halves_) {
    half.facts = facts_, half.facts.scratch = take(scratch);
    half.saved = take((static_cast<std::size_t>(half.blocks) + 1) * state);
    for (int block = 0; block <= half.blocks; ++block) start_path(facts_, saved(half, block));
    half.costs = take(volume), half.sums = take(volume);
    half.row = {take(line), take(line), take(line), take(line), take(line), take(line) + padded};
  }
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

/// `given` is copied, for bytes that are stored may lie anywhere else.
void Sgm::finish_row(const SgmRowOutput& given, int y, SgmResult& result) const {
  const SgmRowOutput row = given;
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

/// The path's state before a block of rows; after the last block, where it arrives at the middle.
std::uint8_t* Sgm::saved(const Half& half, int block) const {
  return half.saved + static_cast<std::size_t>(block) * rounded_up(state_size(facts_));
}

void Sgm::sweep_down(const hal::GrayImage& left, SgmResult& result) {
  const Half& all = halves_[0];
  start_path(facts_, all.saved);
  for (int y = 0; y < search_.height; ++y) {
    const SgmRowInput row = input(left, y, y - 1);
    kernels_.forward(all.facts, row, all.saved, all.costs, all.sums);
    kernels_.backward(all.facts, row, nullptr, all.costs, all.sums, all.row);
    finish_row(all.row, y, result);
  }
}

/// The path from the edge to the middle is needed where the one across the middle comes by, and keeping it
/// for the whole image would take more time than finding it twice: this first sweep leaves its state before
/// each block of rows, and from there leave_middle() finds it again, block by block.
void Sgm::approach_middle(const hal::GrayImage& left, const Half& half) const {
  start_path(facts_, saved(half, 0));
  const std::uint8_t* before = saved(half, 0);
  for (int i = 0; i < half.rows; ++i) {
    std::uint8_t* const state = saved(half, i / block_rows_ + 1);
    const int y = half.row_at(i);
    kernels_.vertical(half.facts, input(left, y, y - half.step), before, state);
    before = state;
  }
}

/// `across` is the path's state that arrives from the other half.
void Sgm::leave_middle(const hal::GrayImage& left, const Half& half, std::uint8_t* across,
                       SgmResult& result) const {
  const std::size_t row_bytes =
      static_cast<std::size_t>(facts_.width) * static_cast<std::size_t>(facts_.padded);
  for (int block = half.blocks - 1; block >= 0; --block) {
    const int first = block * block_rows_, end = std::min(first + block_rows_, half.rows);
    const auto in_block = [&](std::uint8_t* volume, int i) {
      return volume + static_cast<std::size_t>(i - first) * row_bytes;
    };
    for (int i = first; i < end; ++i) {
      const int y = half.row_at(i);
      kernels_.forward(half.facts, input(left, y, y - half.step), saved(half, block), in_block(half.costs, i),
                       in_block(half.sums, i));
    }
    for (int i = end - 1; i >= first; --i) {
      const int y = half.row_at(i);
      kernels_.backward(half.facts, input(left, y, y + half.step), across, in_block(half.costs, i),
                        in_block(half.sums, i), half.row);
      finish_row(half.row, y, result);
    }
  }
}

/// With four paths each processor takes one half of the image: from its edge to the middle, where the two
/// paths are exchanged, and back. Neither waits for the other but there, and nothing is done twice.
void Sgm::match(const SgmSearch& search, const SgmPenalties& penalties, const hal::GrayImage& left,
                const hal::GrayImage& right, hal::TwoProcessors& processors, SgmResult& result) {
  prepare(search, penalties);
  processors.both([&] { left_.compute(left, false, 0); },
                  [&] { right_.compute(right, true, std::abs(search.lowest) + facts_.padded); });
  const std::size_t size = static_cast<std::size_t>(search.width) * static_cast<std::size_t>(search.height);
  result.disparity.assign(size, SgmResult::kNone);
  result.least.assign(size, 255), result.second.assign(size, 255);
  result.disagreement.assign(size, SgmResult::kOutside);
  if (penalties.paths != 4) return sweep_down(left, result);
  const Half &above = halves_[0], &below = halves_[1];
  processors.both([&] { approach_middle(left, above); }, [&] { approach_middle(left, below); });
  processors.both([&] { leave_middle(left, above, saved(below, below.blocks), result); },
                  [&] { leave_middle(left, below, saved(above, above.blocks), result); });
}

}  // namespace headway::vision
