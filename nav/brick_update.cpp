#include "nav/brick_update.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/brick_update.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set. Only exact operations are used (no
// approximate reciprocals, no fused sums), so that all of them give the same bytes.
HWY_BEFORE_NAMESPACE();
namespace headway::nav {

#ifndef HEADWAY_BRICK_SWEEP
#define HEADWAY_BRICK_SWEEP
namespace {

constexpr int kBoxes = 8;  // classified together: bricks of a row, or the cubes of a brick
constexpr int kCubeVoxels = 64, kRows = 16;
constexpr float kMostSteps = 32767;

// Added to a float of less than 2^22 it leaves the nearest whole number in the lower bits.
constexpr float kToWhole = 12582912;  // 1.5 * 2^23
constexpr std::uint32_t kToWholeBits = 0x4b400000;

/// Coordinates of the camera's frame in steps of depth, X and Y times the focal length (so that X/Z is in
/// samples), as linear forms of a voxel's whole coordinates x, y, z and 1.
struct CameraForms {
  float u[4], v[4], z[4];
};

/// What the sweep needs to know; nothing here changes from brick to brick.
struct Sweep {
  CameraForms forms;
  Eigen::Vector3i first, last;  // the box of bricks that may lie in the view, inclusive
  float planes[6][4];           // a brick's centre voxel (x, y, z, 1) may be in view where all are >= 0
  float cx, cy, end_u, end_v;
  float near, far;          // steps
  float half_voxel;         // half an edge of a voxel, as forms.u has it
  int width, height;        // samples
  const SampleWord* words;  // with the ring
  std::int32_t stride;
  std::int32_t first_word;  // makes up for what kToWhole leaves in a row and a column
  const DepthBounds* bounds;
  const SampleClasses* classes;
  VoxelMarks* marks;
  LogOdds least_hit;
  bool wide;  // some hits are less than least_hit
  Time stamp;
};

/// The voxels of the foot, and those where an obstacle's hit tells of the foot, of a cube of 4x4x4.
struct FootMasks {
  std::uint64_t foot = 0, obstacle = 0;
};

/// What happened to one brick.
struct BrickChange {
  int unseen = 0, occupied = 0;  // differences
  bool changed = false;
};

/// What one cube's voxels are told, as bits in their order.
struct CubeBits {
  std::uint64_t hits = 0, misses = 0;
};

struct Boxes {
  alignas(64) float u[kBoxes], v[kBoxes], z[kBoxes];  // their middles
};
struct Extent {
  float u, v, z;  // half of it
};
struct Place {
  float u, v, z;
};
/// Bit per box.
struct BoxClasses {
  unsigned alive = 0;   // may hold voxels that learn something
  unsigned empty = 0;   // all of their voxels are empty
  unsigned inside = 0;  // all of their voxels lie wholly in the image
};

FootMasks foot_masks(const VoxelMap& map, int first_layer);

}  // namespace
#endif

namespace HWY_NAMESPACE {
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

/// Eight boxes at once, by bounds that hold for each of their voxels.
HWY_INLINE BoxClasses classify(const Sweep& s, const Boxes& boxes, const Extent& half) {
  using B = hn::CappedTag<float, kBoxes>;
  constexpr B b;
  constexpr hn::RebindToSigned<B> bi;
  constexpr hn::RebindToUnsigned<B> bu;
  using VB = hn::Vec<B>;
  const auto set_b = [b](float value) HWY_ATTR { return hn::Set(b, value); };
  const auto bits = [b](auto mask) HWY_ATTR {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(b, mask, bytes);
    return static_cast<unsigned>(bytes[0]);
  };
  constexpr float kRounding = 0.01F;  // samples; more than rounding moves any projection
  BoxClasses result;
  for (int i = 0; i < kBoxes; i += static_cast<int>(hn::Lanes(b))) {
    const VB z = hn::Load(b, boxes.z + i), u = hn::Load(b, boxes.u + i), v = hn::Load(b, boxes.v + i);
    const VB z0 = hn::Sub(z, set_b(half.z)), z1 = hn::Add(z, set_b(half.z));
    const auto close = hn::Le(z0, set_b(s.near + 1));
    auto dead = hn::Or(hn::Lt(z1, set_b(s.near - 1)), hn::Gt(z0, set_b(s.far + 1)));
    const VB q0 = hn::Div(set_b(1), hn::Max(z0, set_b(1))), q1 = hn::Div(set_b(1), hn::Max(z1, set_b(1)));
    // The extremes of X/Z lie at the corners of the box around the box.
    const auto low_end = [&](VB x, float reach, float offset) HWY_ATTR {
      const VB low = hn::Sub(x, set_b(reach));
      return hn::Add(hn::Mul(low, hn::IfThenElse(hn::Lt(low, hn::Zero(b)), q0, q1)),
                     set_b(offset - kRounding));
    };
    const auto high_end = [&](VB x, float reach, float offset) HWY_ATTR {
      const VB high = hn::Add(x, set_b(reach));
      return hn::Add(hn::Mul(high, hn::IfThenElse(hn::Lt(high, hn::Zero(b)), q1, q0)),
                     set_b(offset + kRounding));
    };
    const VB u0 = low_end(u, half.u, s.cx), u1 = high_end(u, half.u, s.cx);
    const VB v0 = low_end(v, half.v, s.cy), v1 = high_end(v, half.v, s.cy);
    const VB low = set_b(-0.5F);
    const auto outside = hn::Or(hn::Or(hn::Lt(u1, low), hn::Lt(v1, low)),
                                hn::Or(hn::Ge(u0, set_b(s.end_u)), hn::Ge(v0, set_b(s.end_v))));
    const VB inset = hn::Sub(hn::Mul(set_b(s.half_voxel), q0), set_b(0.5F - kRounding));
    const VB right = hn::Sub(set_b(s.end_u - 0.5F), inset), bottom = hn::Sub(set_b(s.end_v - 0.5F), inset);
    auto inside = hn::And(hn::And(hn::Ge(u0, inset), hn::Ge(v0, inset)),
                          hn::And(hn::Lt(u1, right), hn::Lt(v1, bottom)));
    inside = hn::And(hn::AndNot(close, inside), hn::Lt(z1, set_b(kMostSteps - 2)));
    dead = hn::Or(dead, hn::AndNot(close, outside));

    const auto cell = [b, bu](VB x, int size) HWY_ATTR {
      const VB within = hn::Min(hn::Max(x, hn::Zero(b)), hn::Set(b, static_cast<float>(size - 1)));
      return hn::BitCast(bu, hn::NearestInt(within));
    };
    const auto a0 = cell(u0, s.width), a1 = cell(u1, s.width), b0 = cell(v0, s.height),
               b1 = cell(v1, s.height);
    const auto two = hn::Set(bu, 2U), one = hn::Set(bu, 1U);
    const auto span = hn::Max(hn::Max(hn::Sub(a1, a0), hn::Sub(b1, b0)), two);
    // The level whose tiles are as long as the span, rounded up to a power of two: from a float's exponent.
    const VB longest = hn::ConvertTo(b, hn::BitCast(bi, hn::Sub(span, one)));
    auto level = hn::Sub(hn::ShiftRight<23>(hn::BitCast(bu, longest)), hn::Set(bu, 126U));
    const auto most = hn::Set(bu, static_cast<std::uint32_t>(DepthBounds::kLevels));
    const auto too_long = hn::RebindMask(b, hn::Gt(level, most));
    level = hn::Min(level, most);
    const auto level_i = hn::BitCast(bi, level);
    const auto start = hn::GatherIndex(bi, s.bounds->start(), level_i),
               width = hn::GatherIndex(bi, s.bounds->width(), level_i);
    const auto x = hn::BitCast(bi, hn::Shr(a0, level)), y = hn::BitCast(bi, hn::Shr(b0, level));
    const auto at = hn::Add(hn::Add(start, hn::Mul(y, width)), x);
    const auto found = hn::GatherIndex(bu, s.bounds->words(), at);
    const VB front = hn::ConvertTo(b, hn::BitCast(bi, hn::And(found, hn::Set(bu, 0xffffU))));
    const VB back = hn::ConvertTo(b, hn::BitCast(bi, hn::ShiftRight<16>(found)));

    const auto unsure = hn::Or(close, too_long);
    const VB step = set_b(1);  // depths are rounded to steps
    dead = hn::Or(dead, hn::AndNot(unsure, hn::Gt(hn::Sub(z0, step), back)));
    const auto empty = hn::AndNot(hn::Or(unsure, dead), hn::And(inside, hn::Lt(hn::Add(z1, step), front)));
    result.alive |= bits(hn::Not(dead)) << i;
    result.empty |= bits(empty) << i;
    result.inside |= bits(inside) << i;
  }
  constexpr unsigned kAll = (1U << kBoxes) - 1;
  return {result.alive & kAll, result.empty & kAll, result.inside & kAll};
}

struct Lookup {
  VI depth;
  VU word;
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

/// The samples that a vector of voxels projects to: those at `offset` from the cube's first.
template <bool kInside>
HWY_INLINE Lookup look_up(const Sweep& s, const VoxelOffsets& offsets, const Place& first, int offset) {
  constexpr auto kRing = static_cast<float>(RingImage<SampleWord>::kRing);
  V z = hn::Add(set(first.z), hn::LoadU(d, offsets.z + offset));
  const V inverse = hn::Div(set(1), z);
  V x = hn::Add(hn::Mul(hn::Add(set(first.u), hn::LoadU(d, offsets.u + offset)), inverse), set(s.cx));
  V y = hn::Add(hn::Mul(hn::Add(set(first.v), hn::LoadU(d, offsets.v + offset)), inverse), set(s.cy));
  if (!kInside) {
    // A voxel that may reach over the image's border says nothing: what stands in its other part is not seen.
    const V inset = hn::Sub(hn::Mul(set(s.half_voxel), inverse), set(0.5F));
    auto seen = hn::And(hn::Ge(z, set(s.near)), hn::Le(z, set(s.far)));
    seen = hn::And(seen, hn::And(hn::Ge(x, inset), hn::Ge(y, inset)));
    seen = hn::And(seen, hn::And(hn::Lt(hn::Add(x, inset), set(s.end_u - 0.5F)),
                                 hn::Lt(hn::Add(y, inset), set(s.end_v - 0.5F))));
    x = hn::IfThenElseZero(seen, x);
    y = hn::IfThenElseZero(seen, y);
    z = hn::IfThenElse(seen, z, set(kMostSteps));
  }
  const VI row = hn::BitCast(di, hn::Add(y, set(kToWhole + kRing))),
           column = hn::BitCast(di, hn::Add(x, set(kToWhole + kRing)));
  const VI at = hn::Add(hn::Add(hn::Mul(row, hn::Set(di, s.stride)), column), hn::Set(di, s.first_word));
  return {hn::BitCast(di, hn::Add(z, set(kToWhole))), hn::GatherIndex(du, s.words, at)};
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

HWY_INLINE void add(LogOdds& value, int evidence, BrickChange& change) {
  if (evidence == 0) return;
  const LogOdds old = value;
  const int sum = (old == log_odds::kUnseen ? 0 : old) + evidence;
  value = static_cast<LogOdds>(std::clamp<int>(sum, log_odds::kLowest, log_odds::kHighest));
  if (value == old) return;
  change.changed = true;
  change.unseen -= old == log_odds::kUnseen;
  change.occupied += (value >= log_odds::kOccupied) - (old >= log_odds::kOccupied);
}

HWY_INLINE void empty_cube(LogOdds* values, BrickChange& change) {
  for (int i = 0; i < kCubeVoxels; ++i) add(values[i], log_odds::kMiss, change);
}

HWY_INLINE void hit_marked(LogOdds* values, std::uint64_t marks, LogOdds hit, BrickChange& change) {
  for (; marks != 0; marks &= marks - 1) add(values[std::countr_zero(marks)], hit, change);
}

template <bool kInside>
HWY_INLINE CubeBits see_cube(const Sweep& s, const VoxelOffsets& offsets, const Place& first,
                             std::uint64_t marks, LogOdds* values, BrickChange& change) {
  CubeBits bits;
  for (int i = 0; i < kCubeVoxels; ++i) {
    const Lookup found = look_up<kInside>(s, offsets, first, kRows * (i & 3) + (i >> 2));
    const int depth = hn::GetLane(found.depth) & 0xffff;
    int e = evidence(s, depth, hn::GetLane(found.word));
    if (marks >> i & 1) e = std::max<int>(e, s.least_hit);
    bits.hits |= static_cast<std::uint64_t>(e > 0) << i;
    bits.misses |= static_cast<std::uint64_t>(e < 0) << i;
    add(values[i], e, change);
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
  const V16 miss = hn::IfThenElseZero(is_empty, set16(log_odds::kMiss));
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
HWY_INLINE void add(LogOdds* values, V8 evidence, BrickChange& change) {
  const V8 unseen_value = set8(log_odds::kUnseen), zero = hn::Zero(d8);
  const V8 old = hn::LoadU(d8, values);
  const auto was_unseen = hn::Eq(old, unseen_value);
  const auto none = hn::Eq(evidence, zero);
  V8 sum = hn::SaturatedAdd(hn::IfThenZeroElse(was_unseen, old), evidence);
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

HWY_INLINE void hit_marked(LogOdds* values, std::uint64_t marks, LogOdds hit, BrickChange& change) {
  for (int i = 0; i < kCubeVoxels; i += kGroup)
    add(values + i, hn::IfThenElseZero(mask_of(marks >> i), set8(hit)), change);
}

HWY_INLINE void empty_cube(LogOdds* values, BrickChange& change) {
  for (int i = 0; i < kCubeVoxels; i += kGroup) add(values + i, set8(log_odds::kMiss), change);
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
    const V16 even = evidence(s, c0, c2), odd = evidence(s, c1, c3);
    V8 e = hn::OddEven(hn::BitCast(d8, hn::ShiftLeft<8>(odd)), hn::BitCast(d8, even));
    if (marks != 0) {
      e = hn::IfThenElse(mask_of(marks >> i), hn::Max(e, set8(s.least_hit)), e);
    }
    bits.hits |= bits_of(hn::Gt(e, hn::Zero(d8))) << i;
    bits.misses |= bits_of(hn::Lt(e, hn::Zero(d8))) << i;
    add(values + i, e, change);
  }
  return bits;
}

#endif

/// The bricks [first, last] of a row along x whose middles may lie in view.
struct Span {
  int first, last;
};
HWY_INLINE Span bricks_of_row(const Sweep& s, float y, float z) {
  float first = static_cast<float>(s.first.x()), last = static_cast<float>(s.last.x());
  for (const auto& p : s.planes) {
    const float at = p[1] * y + p[2] * z + p[3] + p[0] * 3.5F, slope = p[0] * kBrickEdge;
    if (slope > 1e-6F)
      first = std::max(first, -at / slope);
    else if (slope < -1e-6F)
      last = std::min(last, -at / slope);
    else if (at < 0)
      last = first - 1;
    if (!(last >= first - 1)) return {0, -1};
  }
  return {static_cast<int>(std::ceil(first - 1e-3F)), static_cast<int>(std::floor(last + 1e-3F))};
}

/// The sweep over the bricks of a view.
class BrickSweep {
 public:
  BrickSweep(const Sweep& sweep, VoxelMap& map)
      : s_(sweep), map_(map), offsets_(sweep.forms), brick_half_(extent(3.5F)), cube_half_(extent(1.5F)) {}

  IntegrationStats run() {
    for (int z = s_.first.z(); z <= s_.last.z(); ++z) {
      enter_layer(z);
      for (int y = s_.first.y(); y <= s_.last.y(); ++y) see_row(y, z);
    }
    // What is marked beyond all that the view says something else about.
    for (const std::uint32_t number : s_.marks->bricks()) {
      if (!s_.marks->any(number)) continue;
      const Eigen::Vector3i at = marked_brick(number);
      enter_layer(at.z());
      LogOdds* values = map_.edit(map_.brick_index(at)).data();
      BrickChange change;
      for (int cube = 0; cube < kBoxes; ++cube) hit_marks(at, cube, number, values, change);
      finish(at, change);
    }
    return stats_;
  }

 private:
  Extent extent(float half) const {
    const auto along = [&](const float* f) {
      return half * (std::abs(f[0]) + std::abs(f[1]) + std::abs(f[2]));
    };
    return {along(s_.forms.u), along(s_.forms.v), along(s_.forms.z)};
  }

  void enter_layer(int z) {
    for (int half = 0; half < 2; ++half) foot_[half] = foot_masks(map_, kBrickEdge * z + 4 * half);
  }

  HWY_INLINE void see_row(int y, int z) {
    constexpr float kMiddle = 3.5F;  // voxels from a brick's first
    const float middle_y = static_cast<float>(kBrickEdge * y) + kMiddle,
                middle_z = static_cast<float>(kBrickEdge * z) + kMiddle;
    const Span span = bricks_of_row(s_, middle_y, middle_z);
    Boxes bricks;
    for (int x = span.first; x <= span.last; x += kBoxes) {
      for (int i = 0; i < kBoxes; ++i) {
        const float middle_x = static_cast<float>(kBrickEdge * (x + i)) + kMiddle;
        const auto form = [&](const float* f) {
          return f[0] * middle_x + f[1] * middle_y + f[2] * middle_z + f[3];
        };
        bricks.u[i] = form(s_.forms.u);
        bricks.v[i] = form(s_.forms.v);
        bricks.z[i] = form(s_.forms.z);
      }
      const BoxClasses classes = classify(s_, bricks, brick_half_);
      const int count = std::min(kBoxes, span.last - x + 1);
      for (unsigned left = classes.alive & ((1U << count) - 1); left != 0; left &= left - 1) {
        const int i = std::countr_zero(left);
        see_brick({x + i, y, z}, classes.empty >> i & 1, {bricks.u[i], bricks.v[i], bricks.z[i]});
      }
    }
  }

  HWY_INLINE void see_brick(const Eigen::Vector3i& at, bool empty, const Place& middle) {
    const std::size_t number = mark_number(at);
    const bool marked = s_.marks->any(number);
    LogOdds* values = map_.edit(map_.brick_index(at)).data();
    BrickChange change;
    if (empty && !marked) {
      for (int cube = 0; cube < kBoxes; ++cube) empty_whole(at, cube, values, change);
    } else {
      see_cubes(at, middle, marked, number, values, change);
    }
    finish(at, change);
  }

  HWY_INLINE void see_cubes(const Eigen::Vector3i& at, const Place& middle, bool marked, std::size_t number,
                            LogOdds* values, BrickChange& change) {
    const CameraForms& f = s_.forms;
    Boxes cubes;
    for (int i = 0; i < kBoxes; ++i) {
      const float x = i & 1 ? 2.0F : -2.0F, y = i & 2 ? 2.0F : -2.0F, z = i & 4 ? 2.0F : -2.0F;
      cubes.u[i] = middle.u + (f.u[0] * x + f.u[1] * y + f.u[2] * z);
      cubes.v[i] = middle.v + (f.v[0] * x + f.v[1] * y + f.v[2] * z);
      cubes.z[i] = middle.z + (f.z[0] * x + f.z[1] * y + f.z[2] * z);
    }
    const BoxClasses classes = classify(s_, cubes, cube_half_);
    for (unsigned left = classes.alive; left != 0; left &= left - 1) {
      const int cube = std::countr_zero(left);
      const std::uint64_t marks = marked ? s_.marks->word(number, cube) : 0;
      if ((classes.empty >> cube & 1) && marks == 0) {
        empty_whole(at, cube, values, change);
        continue;
      }
      const auto corner = [](const float* form, float of_middle) {
        return of_middle - 1.5F * (form[0] + form[1] + form[2]);
      };
      const Place first{corner(f.u, cubes.u[cube]), corner(f.v, cubes.v[cube]), corner(f.z, cubes.z[cube])};
      LogOdds* of_cube = values + kCubeVoxels * cube;
      tell(at, cube,
           classes.inside >> cube & 1 ? see_cube<true>(s_, offsets_, first, marks, of_cube, change)
                                      : see_cube<false>(s_, offsets_, first, marks, of_cube, change));
    }
    if (!marked) return;
    for (int cube = 0; cube < kBoxes; ++cube)
      if (!(classes.alive >> cube & 1)) hit_marks(at, cube, number, values, change);
    s_.marks->clear(number);
  }

  HWY_INLINE void empty_whole(const Eigen::Vector3i& at, int cube, LogOdds* values, BrickChange& change) {
    empty_cube(values + kCubeVoxels * cube, change);
    tell(at, cube, {0, ~std::uint64_t{0}});
  }

  HWY_INLINE void hit_marks(const Eigen::Vector3i& at, int cube, std::size_t number, LogOdds* values,
                            BrickChange& change) {
    const std::uint64_t marks = s_.marks->word(number, cube);
    if (marks == 0) return;
    hit_marked(values + kCubeVoxels * cube, marks, s_.least_hit, change);
    tell(at, cube, {marks, 0});
  }

  HWY_INLINE void tell(const Eigen::Vector3i& at, int cube, const CubeBits& bits) {
    stats_.hits += static_cast<std::size_t>(std::popcount(bits.hits));
    stats_.misses += static_cast<std::size_t>(std::popcount(bits.misses));
    const FootMasks& m = foot_[cube >> 2];
    const std::uint64_t seen = (m.foot & (bits.hits | bits.misses)) | (m.obstacle & bits.hits);
    if (seen != 0) map_.see_columns(at, cube & 3, columns_of_cube(seen), s_.stamp);
  }

  HWY_INLINE void finish(const Eigen::Vector3i& at, const BrickChange& change) {
    if (!change.changed) return;
    map_.count_change(map_.brick_index(at), change.unseen, change.occupied, s_.stamp);
    stats_.first_seen += static_cast<std::size_t>(-change.unseen);
    ++stats_.bricks_changed;
  }

  // Marks are kept by place in the window.
  std::size_t mark_number(const Eigen::Vector3i& at) const {
    const Eigen::Vector3i& n = map_.bricks();
    return static_cast<std::size_t>((at.z() * n.y() + at.y()) * n.x() + at.x());
  }
  Eigen::Vector3i marked_brick(std::uint32_t number) const {
    const int n = static_cast<int>(number), nx = map_.bricks().x(), ny = map_.bricks().y();
    return {n % nx, n / nx % ny, n / (nx * ny)};
  }

  const Sweep& s_;
  VoxelMap& map_;
  const VoxelOffsets offsets_;
  const Extent brick_half_, cube_half_;
  FootMasks foot_[2];  // of the lower and the upper cubes of the layer in hand
  IntegrationStats stats_;
};

IntegrationStats sweep_bricks(const Sweep& s, VoxelMap& map) { return BrickSweep(s, map).run(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::nav
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(sweep_bricks);

FootMasks foot_masks(const VoxelMap& map, int first_layer) {
  FootMasks masks;
  for (int z = 0; z < 4; ++z) {
    const int layer = first_layer + z;
    const std::uint64_t voxels = std::uint64_t{0xffff} << (16 * z);
    if (layer >= map.foot_begin() && layer < map.foot_end()) masks.foot |= voxels;
    if (layer >= map.foot_end() && map.centre({0, 0, layer}).z() <= map.config().obstacle_height)
      masks.obstacle |= voxels;
  }
  return masks;
}

/// The inclusive box of bricks that may lie in the view.
void bound(Sweep& s, const RangeSamples& samples, const VoxelMap& map,
           const Eigen::Isometry3d& map_from_camera) {
  Eigen::Vector3d low = map_from_camera.translation(), high = low;
  const auto z = static_cast<double>(samples.farthest());
  for (const float u : {-0.5F, samples.end_u()}) {
    for (const float v : {-0.5F, samples.end_v()}) {
      const auto x = static_cast<double>((u - samples.cx()) / samples.focal());
      const auto y = static_cast<double>((v - samples.cy()) / samples.focal());
      const Eigen::Vector3d corner = map_from_camera * Eigen::Vector3d(x * z, y * z, z);
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const double brick = map.resolution() * kBrickEdge;
  const Eigen::Array3d end = map.bricks().cast<double>();
  const auto brick_of = [&](const Eigen::Vector3d& p) -> Eigen::Array3i {
    return ((p - map.lowest()).array() / brick).floor().max(-1).min(end).cast<int>();
  };
  s.first = brick_of(low).max(0);
  s.last = brick_of(high).min(map.bricks().array() - 1);
}

/// The view's six sides, moved out by half a brick.
void set_planes(Sweep& s) {
  const CameraForms& f = s.forms;
  const float left = -0.5F - s.cx, right = s.end_u - s.cx, top = -0.5F - s.cy, bottom = s.end_v - s.cy;
  for (int j = 0; j < 4; ++j) {
    s.planes[0][j] = f.z[j];
    s.planes[1][j] = -f.z[j];
    s.planes[2][j] = f.u[j] - left * f.z[j];
    s.planes[3][j] = right * f.z[j] - f.u[j];
    s.planes[4][j] = f.v[j] - top * f.z[j];
    s.planes[5][j] = bottom * f.z[j] - f.v[j];
  }
  s.planes[0][3] -= s.near;
  s.planes[1][3] += s.far;
  for (auto& p : s.planes) p[3] += 4.0F * (std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]));
}

CameraForms camera_forms(const RangeSamples& samples, const VoxelMap& map,
                         const Eigen::Isometry3d& map_from_camera) {
  const Eigen::Isometry3d camera_from_map = map_from_camera.inverse();
  const Eigen::Vector3d origin = camera_from_map * map.centre({0, 0, 0});
  const Eigen::Matrix3d step = camera_from_map.linear() * map.resolution();
  const auto steps = static_cast<double>(samples.steps_per_metre());
  const double pixels = steps * static_cast<double>(samples.focal());
  CameraForms f{};
  for (int j = 0; j < 4; ++j) {
    const Eigen::Vector3d c = j < 3 ? Eigen::Vector3d(step.col(j)) : origin;
    f.u[j] = static_cast<float>(c.x() * pixels);
    f.v[j] = static_cast<float>(c.y() * pixels);
    f.z[j] = static_cast<float>(c.z() * steps);
  }
  return f;
}

}  // namespace

void update_bricks(const SeenSpace& seen, Time stamp, VoxelMap& map, IntegrationStats& stats) {
  const RangeSamples& samples = seen.samples;
  Sweep s{};
  s.forms = camera_forms(samples, map, seen.map_from_camera);
  s.cx = samples.cx();
  s.cy = samples.cy();
  s.end_u = samples.end_u();
  s.end_v = samples.end_v();
  s.near = samples.near() * samples.steps_per_metre();
  s.far = samples.farthest() * samples.steps_per_metre();
  s.half_voxel = static_cast<float>(map.resolution() / 2) * samples.focal() * samples.steps_per_metre();
  s.width = samples.words().width();
  s.height = samples.words().height();
  s.words = samples.words().data();
  s.stride = static_cast<std::int32_t>(samples.words().stride());
  s.first_word = static_cast<std::int32_t>(
      0U - kToWholeBits * (static_cast<std::uint32_t>(samples.words().stride()) + 1));
  s.bounds = &samples.bounds();
  s.classes = &seen.classes;
  s.marks = &seen.marks;
  s.least_hit = seen.least_hit;
  s.wide = log_odds::kHit - seen.classes.short_of_hit[samples.widest()] < seen.least_hit;
  s.stamp = stamp;
  bound(s, samples, map, seen.map_from_camera);
  set_planes(s);
  const IntegrationStats done = HWY_DYNAMIC_DISPATCH(sweep_bricks)(s, map);
  stats.hits = done.hits;
  stats.misses = done.misses;
  stats.first_seen = done.first_seen;
  stats.bricks_changed = done.bricks_changed;
}

}  // namespace headway::nav
#endif
