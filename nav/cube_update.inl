// What the voxels of a cube of 4x4x4 learn from a view, one by one.
//
// Compiled once for each instruction set (see Highway's foreach_target), hence no ordinary include guard.
#if defined(HEADWAY_CUBE_UPDATE_TOGGLE) == defined(HWY_TARGET_TOGGLE)
#ifdef HEADWAY_CUBE_UPDATE_TOGGLE
#undef HEADWAY_CUBE_UPDATE_TOGGLE
#else
#define HEADWAY_CUBE_UPDATE_TOGGLE
#endif

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include "nav/brick_sweep.h"

HWY_BEFORE_NAMESPACE();
namespace headway::nav::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
constexpr D d;
constexpr hn::RebindToSigned<D> di;
constexpr hn::RebindToUnsigned<D> du;
using V = hn::Vec<D>;
using VI = hn::Vec<decltype(di)>;
using VU = hn::Vec<decltype(du)>;

HWY_INLINE V set(float value) { return hn::Set(d, value); }

struct Lookup {
  VI depth;
  VU word;
  VI whole;  // zero where the voxel may reach over the image's border, else all ones
};

/// Where the voxels of a cube lie from its first: column by column (x), in each of them row by row.
struct VoxelOffsets {
  alignas(64) float u[kCubeVoxels], v[kCubeVoxels], z[kCubeVoxels];
  explicit VoxelOffsets(const CameraForms& f) {
    for (int i = 0; i < kCubeVoxels; ++i) {
      const auto x_ = static_cast<float>(i / kRows), y_ = static_cast<float>(i & 3),
                 z_ = static_cast<float>(i >> 2 & 3);
      u[i] = f.u[0] * x_ + (f.u[1] * y_ + f.u[2] * z_);
      v[i] = f.v[0] * x_ + (f.v[1] * y_ + f.v[2] * z_);
      z[i] = f.z[0] * x_ + (f.z[1] * y_ + f.z[2] * z_);
    }
  }
};

/// Where a sample's word stands, by row and column in the lower halves of what kToWhole leaves.
HWY_INLINE VI word_index(const Sweep& s, VI row, VI column) {
#if HWY_TARGET == HWY_SCALAR
  constexpr std::int32_t kLower = 0xffff;
  return hn::Set(di, (hn::GetLane(row) & kLower) * s.stride + (hn::GetLane(column) & kLower));
#else
  constexpr hn::Repartition<std::int16_t, D> half;
  const auto both = hn::OddEven(hn::BitCast(half, hn::ShiftLeft<16>(row)), hn::BitCast(half, column));
  const auto weights = hn::BitCast(half, hn::Set(di, s.stride << 16 | 1));
  VI rest = hn::Zero(di);
  const VI sum = hn::ReorderWidenMulAccumulate(di, both, weights, hn::Zero(di), rest);
  return hn::RearrangeToOddPlusEven(sum, rest);
#endif
}

/// Where a vector of voxels projects to: those at `offset` from the cube's first.
struct Projected {
  V x, y, z, inverse;
};
HWY_INLINE Projected project(const Sweep& s, const VoxelOffsets& offsets, const Place& first, int offset) {
  const V z = hn::Add(set(first.z), hn::LoadU(d, offsets.z + offset));
  const V inverse = hn::Div(set(1), z);
  const V u = hn::Add(set(first.u), hn::LoadU(d, offsets.u + offset)),
          v = hn::Add(set(first.v), hn::LoadU(d, offsets.v + offset));
  return {hn::Add(hn::Mul(u, inverse), set(s.cx)), hn::Add(hn::Mul(v, inverse), set(s.cy)), z, inverse};
}

/// Which voxels are seen at all, and which of them are so as a whole: at least half a voxel from the image's
/// border, for the view says nothing of what stands in a voxel's part beyond it.
struct Seen {
  hn::Mask<D> centre, whole;
};
HWY_INLINE Seen seen_of(const Sweep& s, const Projected& p) {
  const V across = set((s.end_u + 0.5F) / 2), down = set((s.end_v + 0.5F) / 2);
  const V beyond = hn::Max(hn::Sub(hn::Abs(hn::Sub(p.x, set((s.end_u - 0.5F) / 2))), across),
                           hn::Sub(hn::Abs(hn::Sub(p.y, set((s.end_v - 0.5F) / 2))), down));
  const auto in_depth = hn::And(hn::Ge(p.z, set(s.near)), hn::Le(p.z, set(s.far)));
  const V reach = hn::Mul(set(s.half_voxel), p.inverse);
  return {hn::And(in_depth, hn::Lt(beyond, hn::Zero(d))),
          hn::And(in_depth, hn::Lt(hn::Add(beyond, reach), hn::Zero(d)))};
}
HWY_INLINE VI all_ones(hn::Mask<D> mask) { return hn::VecFromMask(di, hn::RebindMask(di, mask)); }

/// The samples that a vector of voxels projects to.
template <bool kInside>
HWY_INLINE Lookup look_up(const Sweep& s, const VoxelOffsets& offsets, const Place& first, int offset) {
  constexpr auto kRing = static_cast<float>(RingImage<SampleWord>::kRing);
  Projected p = project(s, offsets, first, offset);
  VI whole = hn::Set(di, -1);
  if (!kInside) {
    const Seen seen = seen_of(s, p);
    whole = all_ones(seen.whole);
    p.x = hn::IfThenElseZero(seen.centre, p.x);
    p.y = hn::IfThenElseZero(seen.centre, p.y);
    p.z = hn::IfThenElse(seen.centre, p.z, set(kMostSteps));
  }
  const VI row = hn::BitCast(di, hn::Add(p.y, set(kToWhole + kRing))),
           column = hn::BitCast(di, hn::Add(p.x, set(kToWhole + kRing)));
  const VI at = word_index(s, row, column);
  return {hn::BitCast(di, hn::Add(p.z, set(kToWhole))), hn::GatherIndex(du, s.words, at), whole};
}

#if HWY_TARGET == HWY_SCALAR

// One voxel at a time, in plain numbers: what the other instruction sets are held to.

HWY_INLINE int way_from(int way, std::uint8_t share) { return way * share / 256; }

HWY_INLINE int evidence(const Sweep& s, int depth, SampleWord word) {
  using namespace sample_word;
  const int front = static_cast<int>(word >> kFrontShift);
  const int back = static_cast<int>(word >> kBackShift & kDepthMask);
  const std::size_t kind = word & kClassMask;
  const int way = back - front;
  if (depth < front) return log_odds::kMiss;
  if (depth < front + way_from(way, s.classes->hit_begin[kind]) || depth >= back) return 0;
  const int hit = log_odds::kHit - s.classes->short_of_hit[kind];
  const bool own = depth >= front + way_from(way, s.classes->own_begin[kind]) &&
                   depth <= back - way_from(way, s.classes->own_end[kind]);
  return s.wide && own ? std::max<int>(hit, s.least_hit) : hit;
}

HWY_INLINE void add(const Sweep& s, LogOdds& value, int evidence, BrickChange& change) {
  if (evidence == 0) return;
  const LogOdds old = value;
  const int known = old == log_odds::kUnseen ? 0 : old;
  const int before = evidence < 0 ? std::min<int>(known, log_odds::kMostBeforeMiss)
                                  : std::max<int>(known, s.least_before_hit);
  const int sum = before + evidence;
  value = static_cast<LogOdds>(std::clamp<int>(sum, log_odds::kLowest, log_odds::kHighest));
  if (value == old) return;
  change.changed = true;
  change.unseen -= old == log_odds::kUnseen;
  change.occupied += (value >= log_odds::kOccupied) - (old >= log_odds::kOccupied);
}

HWY_INLINE void empty_cube(const Sweep& s, LogOdds* values, BrickChange& change) {
  for (int i = 0; i < kCubeVoxels; ++i) add(s, values[i], log_odds::kMiss, change);
}

HWY_INLINE void hit_marked(const Sweep& s, LogOdds* values, std::uint64_t marks, BrickChange& change) {
  for (; marks != 0; marks &= marks - 1) add(s, values[std::countr_zero(marks)], s.least_hit, change);
}

template <bool kInside>
HWY_INLINE CubeBits see_cube(const Sweep& s, const VoxelOffsets& offsets, const Place& first,
                             std::uint64_t marks, LogOdds* values, BrickChange& change) {
  CubeBits bits;
  for (int i = 0; i < kCubeVoxels; ++i) {
    const Lookup found = look_up<kInside>(s, offsets, first, kRows * (i & 3) + (i >> 2));
    const int depth = hn::GetLane(found.depth) & 0xffff;
    int e = evidence(s, depth, hn::GetLane(found.word));
    if (!kInside && hn::GetLane(found.whole) == 0) e = std::max(e, 0);
    if (marks >> i & 1) e = std::max<int>(e, s.least_hit);
    bits.hits |= static_cast<std::uint64_t>(e > 0) << i;
    bits.misses |= static_cast<std::uint64_t>(e < 0) << i;
    add(s, values[i], e, change);
  }
  return bits;
}

HWY_INLINE CubeBits empty_seen(const Sweep& s, const VoxelOffsets& offsets, const Place& first,
                               LogOdds* values, BrickChange& change) {
  CubeBits bits;
  for (int i = 0; i < kCubeVoxels; ++i) {
    if (hn::AllFalse(d, seen_of(s, project(s, offsets, first, kRows * (i & 3) + (i >> 2))).whole)) continue;
    bits.misses |= std::uint64_t{1} << i;
    add(s, values[i], log_odds::kMiss, change);
  }
  return bits;
}

#else

constexpr hn::Repartition<std::int16_t, D> d16;
constexpr hn::Repartition<std::uint16_t, D> du16;
constexpr hn::Repartition<std::int8_t, D> d8;
constexpr hn::Repartition<std::uint8_t, D> du8;
using V16 = hn::Vec<decltype(d16)>;
using V8 = hn::Vec<decltype(d8)>;

// Voxels taken together: four vectors of 32 bits, one of bytes. Vector x holds the voxels with that x, one of
// each row, so that two steps of dealing lanes out bring them into their order in the brick.
constexpr int kGroup = 4 * static_cast<int>(hn::MaxLanes(d));

HWY_INLINE V16 set16(int value) { return hn::Set(d16, static_cast<std::int16_t>(value)); }
HWY_INLINE V8 set8(int value) { return hn::Set(d8, static_cast<std::int8_t>(value)); }

template <class Mask8>
HWY_INLINE std::uint64_t bits_of(Mask8 mask) {
  hwy::UnsignedFromSize<kGroup / 8> bits;
  std::uint8_t bytes[8];
  hn::StoreMaskBits(d8, mask, bytes);
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

HWY_INLINE hn::Mask<decltype(d8)> mask_of(std::uint64_t bits) {
  std::uint8_t bytes[8];
  std::memcpy(bytes, &bits, sizeof bits);
  return hn::LoadMaskBits(d8, bytes);
}

/// Two vectors of 32 bits as one of 16: the first in the even lanes.
HWY_INLINE V16 deal(VI even, VI odd) {
  return hn::OddEven(hn::BitCast(d16, hn::ShiftLeft<16>(odd)), hn::BitCast(d16, even));
}

/// The values of a table by class, in 16 bits; of class 0 it holds zero.
HWY_INLINE V16 by_class(const SampleClasses::Table& table, V16 kind) {
  const auto values = hn::LoadDup128(du8, table.data());
  return hn::BitCast(d16, hn::TableLookupBytes(values, hn::BitCast(du8, kind)));
}

/// Share (in 256ths) of a way of less than 2^14 steps.
HWY_INLINE V16 share(V16 way, V16 part) {
  return hn::BitCast(
      d16, hn::MulHigh(hn::BitCast(du16, hn::ShiftLeft<2>(way)), hn::BitCast(du16, hn::ShiftLeft<6>(part))));
}

/// What voxels learn: two vectors of voxels against the samples that they project to.
template <bool kInside>
HWY_INLINE V16 evidence(const Sweep& s, const Lookup& a, const Lookup& b) {
  using namespace sample_word;
  const V16 depth = deal(a.depth, b.depth);
  const V16 front = hn::OddEven(hn::BitCast(d16, hn::ShiftRight<kFrontShift - 16>(b.word)),
                                hn::BitCast(d16, hn::ShiftRight<kFrontShift>(a.word)));
  const V16 back = hn::And(hn::OddEven(hn::BitCast(d16, hn::ShiftLeft<16 - kBackShift>(b.word)),
                                       hn::BitCast(d16, hn::ShiftRight<kBackShift>(a.word))),
                           set16(kDepthMask));
  const V16 kind = hn::And(deal(hn::BitCast(di, a.word), hn::BitCast(di, b.word)), set16(kClassMask));
  const V16 way = hn::Sub(back, front);
  const V16 begin = hn::Add(front, share(way, by_class(s.classes->hit_begin, kind)));
  const auto is_empty = hn::Lt(depth, front);
  const auto is_hit = hn::AndNot(hn::Gt(begin, depth), hn::Lt(depth, back));
  V16 miss = hn::IfThenElseZero(is_empty, set16(log_odds::kMiss));
  if (!kInside) miss = hn::And(miss, deal(a.whole, b.whole));
  if (hn::AllFalse(d16, is_hit)) return miss;
  V16 hit = hn::Sub(set16(log_odds::kHit), by_class(s.classes->short_of_hit, kind));
  if (s.wide) {
    const V16 own_begin = hn::Add(front, share(way, by_class(s.classes->own_begin, kind)));
    const V16 own_end = hn::Sub(back, share(way, by_class(s.classes->own_end, kind)));
    const auto own = hn::Not(hn::Or(hn::Gt(own_begin, depth), hn::Gt(depth, own_end)));
    hit = hn::Max(hit, hn::IfThenElseZero(own, set16(s.least_hit)));
  }
  return hn::Or(miss, hn::IfThenElseZero(is_hit, hit));
}

/// Adds evidence to a vector of values.
HWY_INLINE void add(const Sweep& s, LogOdds* values, V8 evidence, BrickChange& change) {
  const V8 unseen_value = set8(log_odds::kUnseen), zero = hn::Zero(d8);
  const V8 old = hn::LoadU(d8, values);
  const auto was_unseen = hn::Eq(old, unseen_value);
  const auto none = hn::Eq(evidence, zero);
  const V8 known = hn::IfThenZeroElse(was_unseen, old);
  const V8 before_miss = hn::Min(known, set8(log_odds::kMostBeforeMiss)),
           before_hit = hn::Max(known, set8(s.least_before_hit));
  V8 sum = hn::SaturatedAdd(hn::IfThenElse(hn::Lt(evidence, zero), before_miss, before_hit), evidence);
  sum = hn::Max(hn::Min(sum, set8(log_odds::kHighest)), set8(log_odds::kLowest));
  sum = hn::IfThenElse(none, old, sum);
  if (hn::AllTrue(d8, hn::Eq(sum, old))) return;
  hn::StoreU(sum, d8, values);
  change.changed = true;
  change.unseen -= static_cast<int>(hn::CountTrue(d8, hn::AndNot(none, was_unseen)));
  const V8 just_empty = set8(log_odds::kOccupied - 1);
  change.occupied += static_cast<int>(hn::CountTrue(d8, hn::Gt(sum, just_empty))) -
                     static_cast<int>(hn::CountTrue(d8, hn::Gt(old, just_empty)));
}

HWY_INLINE void hit_marked(const Sweep& s, LogOdds* values, std::uint64_t marks, BrickChange& change) {
  for (int i = 0; i < kCubeVoxels; i += kGroup)
    add(s, values + i, hn::IfThenElseZero(mask_of(marks >> i), set8(s.least_hit)), change);
}

HWY_INLINE void empty_cube(const Sweep& s, LogOdds* values, BrickChange& change) {
  for (int i = 0; i < kCubeVoxels; i += kGroup) add(s, values + i, set8(log_odds::kMiss), change);
}

template <bool kInside>
HWY_INLINE CubeBits see_cube(const Sweep& s, const VoxelOffsets& offsets, const Place& first,
                             std::uint64_t marks, LogOdds* values, BrickChange& change) {
  CubeBits bits;
  for (int i = 0; i < kCubeVoxels; i += kGroup) {
    const int row = i / 4;
    const Lookup c0 = look_up<kInside>(s, offsets, first, row),
                 c1 = look_up<kInside>(s, offsets, first, row + kRows),
                 c2 = look_up<kInside>(s, offsets, first, row + 2 * kRows),
                 c3 = look_up<kInside>(s, offsets, first, row + 3 * kRows);
    const V16 even = evidence<kInside>(s, c0, c2), odd = evidence<kInside>(s, c1, c3);
    V8 e = hn::OddEven(hn::BitCast(d8, hn::ShiftLeft<8>(odd)), hn::BitCast(d8, even));
    if (marks != 0) {
      e = hn::IfThenElse(mask_of(marks >> i), hn::Max(e, set8(s.least_hit)), e);
    }
    bits.hits |= bits_of(hn::Gt(e, hn::Zero(d8))) << i;
    bits.misses |= bits_of(hn::Lt(e, hn::Zero(d8))) << i;
    add(s, values + i, e, change);
  }
  return bits;
}

/// What lies wholly in the image of a cube in front of all that the view shows there.
HWY_INLINE CubeBits empty_seen(const Sweep& s, const VoxelOffsets& offsets, const Place& first,
                               LogOdds* values, BrickChange& change) {
  CubeBits bits;
  for (int i = 0; i < kCubeVoxels; i += kGroup) {
    const auto whole = [&](int x) HWY_ATTR {
      return all_ones(seen_of(s, project(s, offsets, first, i / 4 + x * kRows)).whole);
    };
    const V16 even = deal(whole(0), whole(2)), odd = deal(whole(1), whole(3));
    const V8 seen = hn::OddEven(hn::BitCast(d8, odd), hn::BitCast(d8, even));
    bits.misses |= bits_of(hn::Lt(seen, hn::Zero(d8))) << i;
    add(s, values + i, hn::And(seen, set8(log_odds::kMiss)), change);
  }
  return bits;
}

#endif

}  // namespace
}  // namespace headway::nav::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
