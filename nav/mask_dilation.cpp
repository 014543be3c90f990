#include "nav/mask_dilation.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/mask_dilation.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace headway::nav::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kWords = kBlockCells / 64;
constexpr int kBefore = 2, kRoom = 2 * kWords;  // words of a row in hand: two before the block, two behind it
constexpr hn::CappedTag<std::uint64_t, kWords> d64;
using Words = hn::Vec<decltype(d64)>;
HWY_INLINE int lanes64() { return static_cast<int>(hn::Lanes(d64)); }

/// Words from `word` on, moved so that bit x becomes bit x + by.
HWY_INLINE Words ahead(const std::uint64_t* word, int by) {
  word += by >> 6;
  const int bits = by & 63;
  if (bits == 0) return hn::LoadU(d64, word);
  return hn::Or(hn::ShiftRightSame(hn::LoadU(d64, word), bits),
                hn::ShiftLeftSame(hn::LoadU(d64, word + 1), 64 - bits));
}

/// Puts the motions of eight slots, eight chunks each, where the chunks keep them.
template <bool kMore>
HWY_INLINE void deal_out(const std::uint64_t (*hit)[kWords], int slot, int half, FloorChunk* chunks) {
#if HWY_TARGET == HWY_SCALAR
  for (int s = slot; s < slot + 8; ++s) {
    for (int c = 8 * half; c < 8 * half + 8; ++c) {
      const auto bits = static_cast<std::uint16_t>(hit[s][c / 4] >> (16 * (c % 4)));
      std::uint16_t& blocked = chunks[c].blocked[static_cast<std::size_t>(s)];
      blocked = kMore ? static_cast<std::uint16_t>(blocked | bits) : bits;
    }
  }
#else
  constexpr hn::CappedTag<std::uint16_t, 8> d16;
  constexpr hn::RepartitionToWide<decltype(d16)> d32;
  constexpr hn::RepartitionToWide<decltype(d32)> d64_2;
  using V = hn::Vec<decltype(d16)>;
  V a[8], b[8];
  HWY_UNROLL(8)
  for (int i = 0; i < 8; ++i) a[i] = hn::BitCast(d16, hn::LoadU(d64_2, hit[slot + i] + 2 * half));
  HWY_UNROLL(4)
  for (int i = 0; i < 4; ++i) {
    b[2 * i] = hn::InterleaveLower(d16, a[2 * i], a[2 * i + 1]);
    b[2 * i + 1] = hn::InterleaveUpper(d16, a[2 * i], a[2 * i + 1]);
  }
  HWY_UNROLL(2)
  for (int i = 0; i < 2; ++i) {
    HWY_UNROLL(2)
    for (int k = 0; k < 2; ++k) {
      const auto low = hn::BitCast(d32, b[4 * i + k]), high = hn::BitCast(d32, b[4 * i + k + 2]);
      a[4 * i + 2 * k] = hn::BitCast(d16, hn::InterleaveLower(d32, low, high));
      a[4 * i + 2 * k + 1] = hn::BitCast(d16, hn::InterleaveUpper(d32, low, high));
    }
  }
  HWY_UNROLL(4)
  for (int k = 0; k < 4; ++k) {
    const auto low = hn::BitCast(d64_2, a[k]), high = hn::BitCast(d64_2, a[4 + k]);
    b[2 * k] = hn::BitCast(d16, hn::InterleaveLower(d64_2, low, high));
    b[2 * k + 1] = hn::BitCast(d16, hn::InterleaveUpper(d64_2, low, high));
  }
  HWY_UNROLL(8)
  for (int c = 0; c < 8; ++c) {
    std::uint16_t* blocked = chunks[8 * half + c].blocked.data() + slot;
    hn::StoreU(kMore ? hn::Or(b[c], hn::LoadU(d16, blocked)) : b[c], d16, blocked);
  }
#endif
}

HWY_INLINE Passage passage_of(const FloorChunk& chunk) {
  constexpr hn::CappedTag<std::uint16_t, 8> d16;
  auto all = hn::LoadU(d16, chunk.blocked.data()), any = all;
  for (int i = 0; i < kConfigurations; i += static_cast<int>(hn::Lanes(d16))) {
    const auto bits = hn::LoadU(d16, chunk.blocked.data() + i);
    all = hn::And(all, bits);
    any = hn::Or(any, bits);
  }
  std::uint16_t each[8], some[8];
  hn::StoreU(all, d16, each);
  hn::StoreU(any, d16, some);
  for (int i = 1; i < static_cast<int>(hn::Lanes(d16)); ++i) {
    each[0] &= each[i];
    some[0] |= some[i];
  }
  if (each[0] == 0xffff) return Passage::kClosed;
  return some[0] == 0 ? Passage::kOpen : Passage::kPartly;
}

/// One block of columns, from its first row to its last.
template <bool kMore>
class Column {
 public:
  Column(const MaskDilation& masks, const CellBits& obstacles, FloorChunks& into, int block,
         std::uint64_t* ring)
      : masks_(masks),
        obstacles_(obstacles),
        into_(into),
        block_(block),
        rows_(static_cast<int>(std::bit_ceil(static_cast<unsigned>(masks.highest() - masks.lowest() + 1)))),
        ring_(ring) {}

  HWY_INLINE void run(int first_row, int last_row) {
    for (int y = first_row + masks_.lowest(); y < first_row + masks_.highest(); ++y) dilate(y);
    for (int y = first_row; y <= last_row; ++y) {
      dilate(y + masks_.highest());
      if (y + masks_.highest() - last_obstacle_ > masks_.highest() - masks_.lowest())
        nothing(y);
      else
        meet(y);
    }
  }

 private:
  std::uint64_t* dilated(int y) {
    return ring_ + static_cast<std::size_t>(y & (rows_ - 1)) * masks_.spans().size() * kWords;
  }

  /// A row of obstacles under every span.
  HWY_INLINE void dilate(int y) {
    const std::uint64_t* row = obstacles_.row(y) + block_ * kWords;
    std::uint64_t any = 0;
    for (int w = -kBefore; w < kRoom - kBefore; ++w) any |= row[w];
    const std::vector<MaskDilation::Span>& spans = masks_.spans();
    std::uint64_t* into = dilated(y);
    if (any == 0) {
      std::fill_n(into, spans.size() * kWords, 0);
      return;
    }
    last_obstacle_ = y;
    std::uint64_t run[kRoom];  // the row under a run of `length` cells from its cell on
    int length = 0;
    std::fill_n(run, kRoom, 0);
    for (std::size_t s = 0; s < spans.size(); ++s) {  // by rising length
      for (; length < spans[s].length; ++length) {
        for (int w = 0; w < kRoom; w += lanes64())
          hn::StoreU(hn::Or(hn::LoadU(d64, run + w), ahead(row + w - kBefore, length)), d64, run + w);
      }
      for (int w = 0; w < kWords; w += lanes64())
        hn::StoreU(ahead(run + kBefore + w, spans[s].first), d64,
                   into + s * kWords + static_cast<std::size_t>(w));
    }
  }

  HWY_INLINE void nothing(int y) {
    if (kMore) return;
    FloorChunk* chunks = into_.row(y) + block_ * kBlockChunks;
    for (int c = 0; c < kBlockChunks; ++c) chunks[c].blocked.fill(0);
    std::fill_n(into_.passage(y) + block_ * kBlockChunks, kBlockChunks, Passage::kOpen);
  }

  /// Where each mask meets an obstacle.
  HWY_INLINE void meet(int y) {
    const std::uint64_t* row[128];
    for (int i = 0; i <= masks_.highest() - masks_.lowest(); ++i) row[i] = dilated(y + masks_.lowest() + i);
    std::uint64_t hit[kConfigurations][kWords];
    for (int slot = 0; slot < kConfigurations; ++slot) {
      const std::vector<MaskDilation::Source>& sources = masks_.sources(slot);
      for (int w = 0; w < kWords; w += lanes64()) {
        Words any = hn::Zero(d64);
        if (masks_.meets(slot))
          for (const MaskDilation::Source& s : sources)
            any = hn::Or(any, hn::LoadU(d64, row[s.row] + s.span * kWords + w));
        hn::StoreU(any, d64, hit[slot] + w);
      }
    }
    FloorChunk* chunks = into_.row(y) + block_ * kBlockChunks;
    for (int slot = 0; slot < kConfigurations; slot += 8) {
      deal_out<kMore>(hit, slot, 0, chunks);
      deal_out<kMore>(hit, slot, 1, chunks);
    }
    Passage* passage = into_.passage(y) + block_ * kBlockChunks;
    for (int c = 0; c < kBlockChunks; ++c) passage[c] = passage_of(chunks[c]);
  }

  const MaskDilation& masks_;
  const CellBits& obstacles_;
  FloorChunks& into_;
  int block_, rows_;
  std::uint64_t* ring_;
  int last_obstacle_ = -1'000'000;
};

template <bool kMore>
void dilate(const MaskDilation& masks, const CellBits& obstacles, const BlockRange& range, FloorChunks& into,
            std::uint64_t* ring) {
  for (int block = range.first_block; block <= range.last_block; ++block)
    Column<kMore>(masks, obstacles, into, block, ring).run(range.first_row, range.last_row);
}

void dilate_anew(const MaskDilation& masks, const CellBits& obstacles, const BlockRange& range,
                 FloorChunks& into, std::uint64_t* ring) {
  dilate<false>(masks, obstacles, range, into, ring);
}
void dilate_more(const MaskDilation& masks, const CellBits& obstacles, const BlockRange& range,
                 FloorChunks& into, std::uint64_t* ring) {
  dilate<true>(masks, obstacles, range, into, ring);
}

}  // namespace
}  // namespace headway::nav::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(dilate_anew);
HWY_EXPORT(dilate_more);

}  // namespace

MaskDilation::MaskDilation(const Masks& masks) {
  for (int c = 0; c < kConfigurations; ++c) {
    for (const Mask::Run& run : masks.of(c).runs) {
      lowest_ = std::min(lowest_, run.dy);
      highest_ = std::max(highest_, run.dy);
      farthest_ = std::max({farthest_, std::abs(run.first), std::abs(run.last)});
      const Span span{run.first, run.last - run.first + 1};
      if (std::find(spans_.begin(), spans_.end(), span) == spans_.end()) spans_.push_back(span);
    }
  }
  std::stable_sort(spans_.begin(), spans_.end(),
                   [](const Span& a, const Span& b) { return a.length < b.length; });
  for (int heading = 0; heading < kHeadings; ++heading) {
    for (int number = 0; number < kMotions; ++number) {
      const Motion m{heading, number};
      for (const Mask::Run& run : masks.of(m).runs) {
        sources_[static_cast<std::size_t>(slot_of(m))].push_back(
            {static_cast<std::uint16_t>(run.dy - lowest_),
             span_number({run.first, run.last - run.first + 1})});
      }
    }
  }
  const auto rows = std::bit_ceil(static_cast<std::size_t>(highest_ - lowest_ + 1));
  ring_.resize(rows * spans_.size() * (kBlockCells / 64));
}

std::uint16_t MaskDilation::span_number(const Span& span) {
  return static_cast<std::uint16_t>(std::find(spans_.begin(), spans_.end(), span) - spans_.begin());
}

void MaskDilation::block(const CellBits& obstacles, const BlockRange& range, FloorChunks& into) {
  HWY_DYNAMIC_DISPATCH(dilate_anew)(*this, obstacles, range, into, ring_.data());
}

void MaskDilation::block_more(const CellBits& obstacles, const BlockRange& range, FloorChunks& into,
                              bool straight_on) {
  straight_on_ = straight_on;
  HWY_DYNAMIC_DISPATCH(dilate_more)(*this, obstacles, range, into, ring_.data());
  straight_on_ = true;
}

}  // namespace headway::nav
#endif
