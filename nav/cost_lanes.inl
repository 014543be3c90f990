// The costs of sixteen neighbouring cells as one value, whatever the instruction set has.
//
// Compiled once for each instruction set (see Highway's foreach_target), hence no ordinary include guard.
#if defined(HEADWAY_COST_LANES_TOGGLE) == defined(HWY_TARGET_TOGGLE)
#ifdef HEADWAY_COST_LANES_TOGGLE
#undef HEADWAY_COST_LANES_TOGGLE
#else
#define HEADWAY_COST_LANES_TOGGLE
#endif

#include <algorithm>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include "nav/floor_chunks.h"

HWY_BEFORE_NAMESPACE();
namespace headway::nav::HWY_NAMESPACE {
namespace {

enum class Way { kEast, kWest };  // towards higher x, towards lower x

#if HWY_TARGET <= HWY_AVX2

namespace hn = hwy::HWY_NAMESPACE;
constexpr hn::CappedTag<Ticks, kChunkCells> dc;
using Cells = hn::Vec<decltype(dc)>;

HWY_INLINE Cells load(const Ticks* from) { return hn::LoadU(dc, from); }
HWY_INLINE void store(Cells v, Ticks* to) { hn::StoreU(v, dc, to); }
HWY_INLINE Cells all_of(Ticks value) { return hn::Set(dc, value); }
HWY_INLINE Cells least(Cells a, Cells b) { return hn::Min(a, b); }
HWY_INLINE Cells plus(Cells a, Cells b) { return hn::SaturatedAdd(a, b); }

/// kTooDear where a bit is set.
HWY_INLINE Cells barred(Cells v, std::uint16_t bits) {
  alignas(32) static constexpr Ticks kLane[kChunkCells] = {
      1, 2, 4, 8, 0x10, 0x20, 0x40, 0x80, 0x100, 0x200, 0x400, 0x800, 0x1000, 0x2000, 0x4000, 0x8000};
  const Cells lane = hn::Load(dc, kLane);
  return hn::Or(v, hn::VecFromMask(dc, hn::Eq(hn::And(hn::Set(dc, bits), lane), lane)));
}

/// Not zero where a cost lies below an old one.
HWY_INLINE Cells gain(Cells old, Cells v) { return hn::SaturatedSub(old, v); }
HWY_INLINE Cells either(Cells a, Cells b) { return hn::Or(a, b); }
HWY_INLINE bool none(Cells gain) { return hn::AllTrue(dc, hn::Eq(gain, hn::Zero(dc))); }
/// The new costs where they differ from the old ones, else kTooDear.
HWY_INLINE Cells changed(Cells now, Cells old) { return hn::Or(now, hn::VecFromMask(dc, hn::Eq(now, old))); }

/// The neighbours' costs: of the cell one to the east (`beyond` is the chunk there) or to the west.
template <Way way>
HWY_INLINE Cells neighbours(Cells v, Cells beyond) {
  if constexpr (way == Way::kEast)
    return hn::CombineShiftRightBytes<2>(dc, hn::ConcatLowerUpper(dc, beyond, v), v);
  return hn::CombineShiftRightBytes<14>(dc, v, hn::ConcatLowerUpper(dc, v, beyond));
}

/// The costs `n` cells on (1, 2, 4 or 8), kTooDear beyond the chunk.
template <Way way, int n>
HWY_INLINE Cells cells_on(Cells v) {
  const Cells never = all_of(kTooDear);
  if constexpr (way == Way::kEast) {
    const Cells crossing = hn::ConcatLowerUpper(dc, never, v);
    if constexpr (n == 8) return crossing;
    return hn::CombineShiftRightBytes < n == 8 ? 1 : 2 * n > (dc, crossing, v);
  }
  const Cells crossing = hn::ConcatLowerUpper(dc, v, never);
  if constexpr (n == 8) return crossing;
  return hn::CombineShiftRightBytes < n == 8 ? 1 : 16 - 2 * n > (dc, v, crossing);
}

HWY_INLINE Ticks lowest(Cells v) {
  constexpr hn::Half<decltype(dc)> half;
  const auto eight = hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v));
  return static_cast<Ticks>(_mm_cvtsi128_si32(_mm_minpos_epu16(eight.raw)));
}
HWY_INLINE Ticks first_of(Cells v) { return hn::GetLane(v); }
HWY_INLINE Ticks last_of(Cells v) { return static_cast<Ticks>(_mm256_extract_epi16(v.raw, 15)); }

/// The costs below a limit, else kTooDear.
HWY_INLINE Cells where_below(Cells v, Cells limit) {
  return hn::Or(v, hn::VecFromMask(dc, hn::Eq(hn::SaturatedSub(limit, v), hn::Zero(dc))));
}

/// Bit i: cost i lies below the limit.
HWY_INLINE unsigned below(Cells v, Ticks limit) {
  const auto is_below = hn::Not(hn::Eq(hn::SaturatedSub(hn::Set(dc, limit), v), hn::Zero(dc)));
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(dc, is_below, bytes);
  return bytes[0] | static_cast<unsigned>(bytes[1]) << 8;
}

#else

/// In plain words, which compilers make vectors of.
struct Cells {
  alignas(32) Ticks v[kChunkCells];
};

template <class Of>
HWY_INLINE Cells each(const Of& of) {
  Cells r;
  for (int i = 0; i < kChunkCells; ++i) r.v[i] = static_cast<Ticks>(of(i));
  return r;
}

HWY_INLINE Cells load(const Ticks* from) {
  Cells r;
  std::memcpy(r.v, from, sizeof r.v);
  return r;
}
HWY_INLINE void store(const Cells& v, Ticks* to) { std::memcpy(to, v.v, sizeof v.v); }
HWY_INLINE Cells all_of(Ticks value) {
  return each([&](int) { return value; });
}
HWY_INLINE Cells least(const Cells& a, const Cells& b) {
  return each([&](int i) { return std::min(a.v[i], b.v[i]); });
}
HWY_INLINE Cells plus(const Cells& a, const Cells& b) {
  return each([&](int i) { return std::min(a.v[i] + b.v[i], static_cast<int>(kTooDear)); });
}
HWY_INLINE Cells barred(const Cells& v, std::uint16_t bits) {
  return each([&](int i) { return bits >> i & 1 ? kTooDear : v.v[i]; });
}
HWY_INLINE Cells gain(const Cells& old, const Cells& v) {
  return each([&](int i) { return std::max(old.v[i] - v.v[i], 0); });
}
HWY_INLINE Cells either(const Cells& a, const Cells& b) {
  return each([&](int i) { return a.v[i] | b.v[i]; });
}
HWY_INLINE bool none(const Cells& gain) {
  unsigned any = 0;
  for (const Ticks t : gain.v) any |= t;
  return any == 0;
}
HWY_INLINE Cells changed(const Cells& now, const Cells& old) {
  return each([&](int i) { return now.v[i] == old.v[i] ? kTooDear : now.v[i]; });
}
template <Way way>
HWY_INLINE Cells neighbours(const Cells& v, const Cells& beyond) {
  if constexpr (way == Way::kEast) {
    return each([&](int i) { return i + 1 < kChunkCells ? v.v[i + 1] : beyond.v[0]; });
  }
  return each([&](int i) { return i > 0 ? v.v[i - 1] : beyond.v[kChunkCells - 1]; });
}
template <Way way, int n>
HWY_INLINE Cells cells_on(const Cells& v) {
  return each([&](int i) {
    const int from = way == Way::kEast ? i + n : i - n;
    return from >= 0 && from < kChunkCells ? v.v[from] : kTooDear;
  });
}
HWY_INLINE Cells where_below(const Cells& v, const Cells& limit) {
  return each([&](int i) { return v.v[i] < limit.v[i] ? v.v[i] : kTooDear; });
}
HWY_INLINE Ticks lowest(const Cells& v) { return *std::min_element(v.v, v.v + kChunkCells); }
HWY_INLINE Ticks first_of(const Cells& v) { return v.v[0]; }
HWY_INLINE Ticks last_of(const Cells& v) { return v.v[kChunkCells - 1]; }
HWY_INLINE unsigned below(const Cells& v, Ticks limit) {
  unsigned bits = 0;
  for (int i = 0; i < kChunkCells; ++i) bits |= static_cast<unsigned>(v.v[i] < limit) << i;
  return bits;
}

#endif

}  // namespace
}  // namespace headway::nav::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
