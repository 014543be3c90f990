#include "vision/sgm_rows.h"

#include <bit>
#include <cstdlib>

#define HWY_WANT_AVX3_DL 1  // it counts bits, which the costs are made of
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/sgm_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace headway::vision::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// At most 32 bytes: shifts by one disparity stay cheap, and the layout in memory does not depend on the
// processor.
using D = hn::CappedTag<std::uint8_t, 32>;
using V = hn::Vec<D>;
constexpr D d;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(d));
constexpr int kBlock = 32;  // disparities; kernels are made for multiples of it

HWY_INLINE V set(int value) { return hn::Set(d, static_cast<std::uint8_t>(value)); }

/// How many of four bits differ: those of the row's number from those of the column's.
struct Differences {
  alignas(16) std::uint8_t rows[16][16];
  constexpr Differences() : rows() {
    for (unsigned a = 0; a < 16; ++a)
      for (unsigned b = 0; b < 16; ++b) rows[a][b] = static_cast<std::uint8_t>(std::popcount(a ^ b));
  }
};
constexpr Differences kDifferences;

// Three things that depend on the width of vectors: with_first_of(v, next) is v without its first byte and
// with that of the next vector; with_last_of(v, previous) the opposite; least_byte the least byte in every
// byte.
#if HWY_TARGET == HWY_SCALAR

HWY_INLINE V with_first_of(V, V next) { return next; }
HWY_INLINE V with_last_of(V, V previous) { return previous; }
HWY_INLINE V least_byte(V v) { return v; }
#else

#if HWY_MAX_BYTES >= 32
HWY_INLINE V with_first_of(V v, V next) {
  return hn::CombineShiftRightBytes<1>(d, hn::ConcatLowerUpper(d, next, v), v);
}
HWY_INLINE V with_last_of(V v, V previous) {
  return hn::CombineShiftRightBytes<15>(d, v, hn::ConcatLowerUpper(d, v, previous));
}
#else
HWY_INLINE V with_first_of(V v, V next) { return hn::CombineShiftRightBytes<1>(d, next, v); }
HWY_INLINE V with_last_of(V v, V previous) { return hn::CombineShiftRightBytes<15>(d, v, previous); }
#endif

HWY_INLINE V least_byte(V v) {
  const hn::CappedTag<std::uint8_t, 16> half;
  const hn::RepartitionToWide<decltype(half)> pairs;
#if HWY_MAX_BYTES >= 32
  const auto h = hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v));
#else
  const V h = v;
#endif
  // In the lower byte of each pair.
  const auto low = hn::Min(h, hn::BitCast(half, hn::ShiftRight<8>(hn::BitCast(pairs, h))));
#if HWY_ARCH_X86 && HWY_MAX_BYTES >= 32
  return V{_mm256_broadcastb_epi8(_mm_minpos_epu16(low.raw))};  // Highway would take five instructions more
#else
  const auto all = hn::MinOfLanes(pairs, hn::BitCast(pairs, low));
  const auto least = hn::TableLookupBytes(hn::BitCast(half, all), hn::Zero(half));
#if HWY_MAX_BYTES >= 32
  return hn::Combine(d, least, least);
#else
  return least;
#endif
#endif
}

#endif

// differing(from(a), b) is how many bits of each byte of b differ from those of a: of all eight where bits
// are counted, else of four, and `a` comes sixteenfold.
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_AVX3_DL
constexpr int kParts = Census::kBitPlanes;
HWY_INLINE V from(std::uint8_t bits) { return set(bits); }
HWY_INLINE V differing(V from, V bits) { return hn::PopulationCount(hn::Xor(from, bits)); }
#else
constexpr int kParts = 2 * Census::kBitPlanes;
HWY_INLINE V from(std::uint8_t sixteenfold) { return hn::LoadDup128(d, kDifferences.rows[0] + sixteenfold); }
HWY_INLINE V differing(V from, V bits) { return hn::TableLookupBytes(from, bits); }
#endif

/// All disparities of one pixel.
template <int kBlocks>
struct Pixel {
  static constexpr int kVectors = kBlocks * kBlock / kLanes;
  V v[kVectors];
};

template <int kBlocks>
HWY_INLINE Pixel<kBlocks> load(const std::uint8_t* from) {
  Pixel<kBlocks> p;
  for (int i = 0; i < p.kVectors; ++i) p.v[i] = hn::Load(d, from + i * kLanes);
  return p;
}

template <int kBlocks>
HWY_INLINE void store(const Pixel<kBlocks>& p, std::uint8_t* to) {
  for (int i = 0; i < p.kVectors; ++i) hn::Store(p.v[i], d, to + i * kLanes);
}

template <int kBlocks>
HWY_INLINE Pixel<kBlocks> filled(V value) {
  Pixel<kBlocks> p;
  for (int i = 0; i < p.kVectors; ++i) p.v[i] = value;
  return p;
}

/// The least of all bytes, in every byte.
template <int kBlocks>
HWY_INLINE V least(const Pixel<kBlocks>& p) {
  V m = p.v[0];
  for (int i = 1; i < p.kVectors; ++i) m = hn::Min(m, p.v[i]);
  return least_byte(m);
}

/// At each disparity what stood at the next one; `last` follows after all.
template <int kBlocks>
HWY_INLINE Pixel<kBlocks> next(const Pixel<kBlocks>& p, V last) {
  Pixel<kBlocks> out;
  for (int i = 0; i < p.kVectors; ++i) {
    out.v[i] = with_first_of(p.v[i], i + 1 < p.kVectors ? p.v[i + 1] : last);
  }
  return out;
}

/// At each disparity what stood at the one before; `first` comes before all.
template <int kBlocks>
HWY_INLINE Pixel<kBlocks> previous(const Pixel<kBlocks>& p, V first) {
  Pixel<kBlocks> out;
  for (int i = 0; i < p.kVectors; ++i) {
    out.v[i] = with_last_of(p.v[i], i > 0 ? p.v[i - 1] : first);
  }
  return out;
}

/// For columns whose search leaves the right image: at least kOutsideCost where it does.
template <int kBlocks>
HWY_INLINE void mark_outside(const SgmFacts& f, int x, Pixel<kBlocks>& p) {
  const int padded = kBlocks * kBlock;
  const int reach = x - f.lowest;  // the index of the disparity that leads to column 0
  const int begin = HWY_MIN(HWY_MAX(reach - (f.width - 1), 0), padded);
  const int end = HWY_MAX(HWY_MIN(reach + 1, f.count), 0);
  const std::uint8_t *low = f.outside + padded - begin, *high = f.outside + 2 * padded - end;
  for (int i = 0; i < p.kVectors; ++i)
    p.v[i] = hn::Max(p.v[i], hn::Max(hn::LoadU(d, low + i * kLanes), hn::LoadU(d, high + i * kLanes)));
}

/// Of the columns of one row. Comparisons are taken eight at a time where bits can be counted, else looked up
/// by fours, into which the constructor takes them apart.
template <int kBlocks>
class Costs {
 public:
  HWY_INLINE Costs(const SgmFacts& facts, const SgmRowInput& row)
      : f_(facts),
        left_slope_(row.left[Census::kSlopePlane]),
        right_slope_(row.right[Census::kSlopePlane]),
        inside_(facts.lowest + facts.padded - 1),
        inside_columns_(facts.count == facts.padded ? facts.width - facts.padded + 1 : 0) {
    if constexpr (kParts == Census::kBitPlanes) {
      left_ = row.left[0], left_pitch_ = row.left[1] - row.left[0];
      right_ = row.right[0], right_pitch_ = row.right[1] - row.right[0];
    } else {
      left_pitch_ = right_pitch_ = scratch_pitch(facts);
      left_ = facts.scratch, right_ = left_ + kParts * left_pitch_ + (facts.end_column - 1);
      take_apart(row);
    }
  }

  HWY_INLINE Pixel<kBlocks> at(int x) const {
    Pixel<kBlocks> p = inside(x);
    if (HWY_UNLIKELY(x < inside_ || x >= inside_ + inside_columns_)) mark_outside(f_, x, p);
    return p;
  }

 private:
  HWY_INLINE void take_apart(const SgmRowInput& row) const {
    const int first = f_.first_column, end = f_.end_column;
    for (std::size_t plane = 0; plane < Census::kBitPlanes; ++plane) {
      std::uint8_t *low = f_.scratch + 2 * static_cast<int>(plane) * left_pitch_, *high = low + left_pitch_;
      for (int x = first; x < end; x += kLanes) {
        const V v = hn::LoadU(d, row.left[plane] + x);
        hn::StoreU(hn::ShiftLeft<4>(v), d, low + x);
        hn::StoreU(hn::And(v, set(0xF0)), d, high + x);
      }
      low += kParts * left_pitch_, high += kParts * left_pitch_;
      const std::uint8_t* from = row.right[plane] - (end - 1);
      for (int i = 0; i < end - first + f_.padded; i += kLanes) {
        const V v = hn::LoadU(d, from + i);
        hn::StoreU(hn::And(v, set(0x0F)), d, low + i);
        hn::StoreU(hn::ShiftRight<4>(v), d, high + i);
      }
    }
  }

  HWY_INLINE Pixel<kBlocks> inside(int x) const {
    V census[kParts];
    for (int part = 0; part < kParts; ++part) census[part] = from(left_[x + part * left_pitch_]);
    const V slope = set(left_slope_[x]), cap = set(Census::kSteepest);
    Pixel<kBlocks> out;
    for (int i = 0; i < out.kVectors; ++i) {
      const V other = hn::LoadU(d, right_slope_ - x + i * kLanes);
      V sum = hn::Min(hn::Or(hn::SaturatedSub(slope, other), hn::SaturatedSub(other, slope)), cap);
      for (int part = 0; part < kParts; ++part)
        sum = hn::Add(sum,
                      differing(census[part], hn::LoadU(d, right_ + part * right_pitch_ - x + i * kLanes)));
      out.v[i] = sum;
    }
    return out;
  }

  const SgmFacts& f_;
  const std::uint8_t *left_, *right_;
  std::ptrdiff_t left_pitch_, right_pitch_;  // from part to part
  const std::uint8_t *left_slope_, *right_slope_;
  const int inside_, inside_columns_;  // first and number of those whose search stays in the right image
};

/// A path along the row, in registers. `costs` are not yet lowered by their minimum: finding that takes
/// longest, and so it runs beside the rest.
template <int kBlocks>
struct RowPath {
  Pixel<kBlocks> costs;
  V minimum;

  HWY_INLINE void start() { costs = filled<kBlocks>(hn::Zero(d)), minimum = hn::Zero(d); }
  HWY_INLINE void step(const Pixel<kBlocks>& c, V p1, V p2) {
    const Pixel<kBlocks> a = previous(costs, set(255)), b = next(costs, set(255));
    const V jump = hn::SaturatedAdd(minimum, p2);
    for (int i = 0; i < c.kVectors; ++i) {
      const V beside = hn::SaturatedAdd(hn::Min(a.v[i], b.v[i]), p1);
      const V best = hn::Min(hn::Min(costs.v[i], beside), jump);
      costs.v[i] = hn::Add(best, hn::Sub(c.v[i], minimum));
    }
    minimum = least(costs);
  }
};

/// A path across the rows, in memory, lowered by its minimum. Returns the costs before that.
template <int kBlocks>
HWY_INLINE Pixel<kBlocks> step_in_memory(const std::uint8_t* before, std::uint8_t* state,
                                         const Pixel<kBlocks>& c, V p1, V p2) {
  Pixel<kBlocks> out;
  for (int i = 0; i < c.kVectors; ++i) {
    const std::uint8_t* s = before + i * kLanes;
    const V beside = hn::SaturatedAdd(hn::Min(hn::LoadU(d, s - 1), hn::LoadU(d, s + 1)), p1);
    out.v[i] = hn::Add(hn::Min(hn::Min(hn::Load(d, s), beside), p2), c.v[i]);
  }
  const V minimum = least(out);
  for (int i = 0; i < c.kVectors; ++i) hn::Store(hn::Sub(out.v[i], minimum), d, state + i * kLanes);
  return out;
}

HWY_INLINE V jump_between(const SgmFacts& f, std::uint8_t one, std::uint8_t other) {
  return set(f.p2[std::size_t{255} + one - other]);
}

template <int kBlocks, class Byte>
HWY_INLINE Byte* state_at(Byte* state, int x) {
  return state + static_cast<std::size_t>(x) * (kBlocks * kBlock + kStateMargin) + kStateMargin;
}

template <int kBlocks>
void vertical(const SgmFacts& f, const SgmRowInput& row, const std::uint8_t* before, std::uint8_t* state) {
  const V p1 = set(f.p1);
  const Costs<kBlocks> costs(f, row);
  const int end = f.end_column;
  for (int x = f.first_column; x < end; ++x)
    step_in_memory(state_at<kBlocks>(before, x), state_at<kBlocks>(state, x), costs.at(x), p1,
                   jump_between(f, row.grey[x], row.grey_before[x]));
}

template <int kBlocks>
void forward(const SgmFacts& f, const SgmRowInput& row, std::uint8_t* state, std::uint8_t* costs,
             std::uint8_t* sums) {
  const V p1 = set(f.p1);
  const Costs<kBlocks> found(f, row);
  RowPath<kBlocks> path;
  path.start();
  const int end = f.end_column;
  for (int x = f.first_column; x < end; ++x) {
    const Pixel<kBlocks> c = found.at(x);
    path.step(c, p1, jump_between(f, row.grey[x], row.grey[HWY_MAX(x - 1, 0)]));
    std::uint8_t* const down = state_at<kBlocks>(state, x);
    Pixel<kBlocks> sum = step_in_memory(down, down, c, p1, jump_between(f, row.grey[x], row.grey_before[x]));
    for (int i = 0; i < c.kVectors; ++i) sum.v[i] = hn::SaturatedAdd(sum.v[i], path.costs.v[i]);
    const std::size_t at = static_cast<std::size_t>(x) * kBlocks * kBlock;
    store(c, costs + at);
    store(sum, sums + at);
  }
}

/// The index of the first byte that equals `value`; there is one.
template <int kBlocks>
HWY_INLINE int first_equal(const Pixel<kBlocks>& p, V value) {
  int first = 0;
  for (int i = p.kVectors - 1; i >= 0; --i) {
    const auto equal = hn::Eq(p.v[i], value);
    const int found = i * kLanes + static_cast<int>(hn::FindFirstTrue(d, equal));
    first = hn::AllFalse(d, equal) ? first : found;
  }
  return first;
}

/// The winners of the right image: a window that moves with the left image's column. Place i holds the best
/// of what column x - lowest - i of the right image has met so far; place 0 has met all.
template <int kBlocks>
struct RightWinners {
  Pixel<kBlocks> costs, indices;

  HWY_INLINE void start() { costs = filled<kBlocks>(set(255)), indices = filled<kBlocks>(hn::Zero(d)); }
  HWY_INLINE void meet(const Pixel<kBlocks>& sums) {
    for (int i = 0; i < sums.kVectors; ++i) {
      const V better = hn::Min(costs.v[i], sums.v[i]);
      const V index = hn::Iota(d, static_cast<std::uint8_t>(i * kLanes));
      indices.v[i] = hn::IfThenElse(hn::Eq(better, costs.v[i]), indices.v[i], index);
      costs.v[i] = better;
    }
  }
  HWY_INLINE std::uint8_t first() const { return hn::GetLane(indices.v[0]); }
  HWY_INLINE void move_on() {
    costs = next(costs, set(255));
    indices = next(indices, hn::Zero(d));
  }
};

template <int kBlocks, bool kUp>
void backward(const SgmFacts& f, const SgmRowInput& row, std::uint8_t* state, const std::uint8_t* costs,
              std::uint8_t* sums, const SgmRowOutput& out) {
  constexpr int kPadded = kBlocks * kBlock;
  // 255 at the winner and beside it, where it lies in the middle.
  alignas(64) std::uint8_t beside[2 * kPadded + kBlock] = {};
  beside[kPadded - 1] = beside[kPadded] = beside[kPadded + 1] = 255;
  const V p1 = set(f.p1);
  RowPath<kBlocks> path;
  path.start();
  RightWinners<kBlocks> right;
  right.start();
  for (int x = f.end_column - 1; x >= f.first_column; --x) {
    const std::size_t at = static_cast<std::size_t>(x) * kPadded;
    const Pixel<kBlocks> c = load<kBlocks>(costs + at);
    Pixel<kBlocks> sum = load<kBlocks>(sums + at);
    path.step(c, p1, jump_between(f, row.grey[x], row.grey[HWY_MIN(x + 1, f.width - 1)]));
    for (int i = 0; i < c.kVectors; ++i) sum.v[i] = hn::SaturatedAdd(sum.v[i], path.costs.v[i]);
    if constexpr (kUp) {
      std::uint8_t* const at_x = state_at<kBlocks>(state, x);
      const Pixel<kBlocks> up =
          step_in_memory(at_x, at_x, c, p1, jump_between(f, row.grey[x], row.grey_before[x]));
      for (int i = 0; i < c.kVectors; ++i) sum.v[i] = hn::SaturatedAdd(sum.v[i], up.v[i]);
    }
    store(sum, sums + at);
    const V minimum = least(sum);
    const int winner = first_equal(sum, minimum);
    right.meet(sum);
    out.right_winner[x] = right.first();
    right.move_on();
    for (int i = 0; i < c.kVectors; ++i)
      sum.v[i] = hn::Or(sum.v[i], hn::LoadU(d, beside + kPadded - winner + i * kLanes));
    out.winner[x] = static_cast<std::uint8_t>(winner);
    const int step = winner > 0 && winner < f.count - 1;
    out.below[x] = (sums + at)[winner - step];
    out.above[x] = (sums + at)[winner + step];
    out.least[x] = hn::GetLane(minimum);
    out.second[x] = hn::GetLane(least(sum));
  }
  alignas(64) std::uint8_t rest[kPadded];
  store(right.indices, rest);
  for (int i = 0; i < kPadded; ++i) out.right_winner[f.first_column - 1 - i] = rest[i];
}

template <int kBlocks>
void backward_any(const SgmFacts& f, const SgmRowInput& row, std::uint8_t* state, const std::uint8_t* costs,
                  std::uint8_t* sums, const SgmRowOutput& out) {
  if (state)
    backward<kBlocks, true>(f, row, state, costs, sums, out);
  else
    backward<kBlocks, false>(f, row, state, costs, sums, out);
}

template <int kBlocks>
SgmKernels kernels() {
  return {&vertical<kBlocks>, &forward<kBlocks>, &backward_any<kBlocks>};
}

}  // namespace

SgmKernels SgmKernelsFor(int padded) {
  switch (padded / kBlock) {
    case 1:
      return kernels<1>();
    case 2:
      return kernels<2>();
    case 3:
      return kernels<3>();
    case 4:
      return kernels<4>();
    case 6:
      return kernels<6>();
    default:
      return kernels<8>();
  }
}

}  // namespace headway::vision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {

namespace {
HWY_EXPORT(SgmKernelsFor);
}

int padded_count(int count) {
  for (const int padded : {32, 64, 96, 128, 192})
    if (count <= padded) return padded;
  return 256;
}

SgmKernels sgm_kernels(int padded) { return HWY_DYNAMIC_DISPATCH(SgmKernelsFor)(padded); }

}  // namespace headway::vision
#endif
