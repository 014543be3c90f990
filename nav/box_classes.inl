// Which boxes of voxels a view settles as a whole: those that learn nothing, and those that are all empty.
//
// Compiled once for each instruction set (see Highway's foreach_target), hence no ordinary include guard.
#if defined(HEADWAY_BOX_CLASSES_TOGGLE) == defined(HWY_TARGET_TOGGLE)
#ifdef HEADWAY_BOX_CLASSES_TOGGLE
#undef HEADWAY_BOX_CLASSES_TOGGLE
#else
#define HEADWAY_BOX_CLASSES_TOGGLE
#endif

#include <algorithm>
#include <cstdint>

#include <hwy/highway.h>

#include "nav/brick_sweep.h"

HWY_BEFORE_NAMESPACE();
namespace headway::nav::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Of two words of DepthBounds: the lesser fronts (lower halves) and the greater backs.
template <class VW>
HWY_INLINE VW both_bounds(VW p, VW q) {
  const hn::DFromV<VW> w;
#if HWY_TARGET == HWY_SCALAR
  const std::uint32_t a = hn::GetLane(p), b = hn::GetLane(q);
  return hn::Set(w, std::min(a & 0xffff, b & 0xffff) | std::max(a >> 16, b >> 16) << 16);
#else
  const hn::Repartition<std::uint16_t, decltype(w)> half;
  const auto a = hn::BitCast(half, p), b = hn::BitCast(half, q);
  return hn::BitCast(w, hn::OddEven(hn::Max(a, b), hn::Min(a, b)));
#endif
}

/// Eight boxes at once, by bounds that hold for each of their voxels.
HWY_INLINE BoxClasses classify(const Sweep& s, const Place& from, const Boxes& boxes) {
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
    const VB u = hn::Add(set_b(from.u), hn::Load(b, boxes.u + i)),
             v = hn::Add(set_b(from.v), hn::Load(b, boxes.v + i)),
             z = hn::Add(set_b(from.z), hn::Load(b, boxes.z + i));
    const VB z0 = hn::Sub(z, set_b(boxes.half.z)), z1 = hn::Add(z, set_b(boxes.half.z));
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
    const VB u0 = low_end(u, boxes.half.u, s.cx), u1 = high_end(u, boxes.half.u, s.cx);
    const VB v0 = low_end(v, boxes.half.v, s.cy), v1 = high_end(v, boxes.half.v, s.cy);
    // How far the middles lie on the image's side of its borders: plane by plane, which tells more of a box
    // that stands askew than the box around it.
    const VB from_left = hn::Sub(u, hn::Mul(set_b(s.slopes.left), z)),
             from_right = hn::Sub(hn::Mul(set_b(s.slopes.right), z), u),
             from_top = hn::Sub(v, hn::Mul(set_b(s.slopes.top), z)),
             from_bottom = hn::Sub(hn::Mul(set_b(s.slopes.bottom), z), v);
    const auto least_of = [&](auto combine) HWY_ATTR {
      return hn::Min(
          hn::Min(combine(from_left, set_b(boxes.reach.left)), combine(from_right, set_b(boxes.reach.right))),
          hn::Min(combine(from_top, set_b(boxes.reach.top)),
                  combine(from_bottom, set_b(boxes.reach.bottom))));
    };
    const VB nearest = least_of([](VB side, VB reach) HWY_ATTR { return hn::Sub(side, reach); }),
             farthest = least_of([](VB side, VB reach) HWY_ATTR { return hn::Add(side, reach); });
    const VB margin = hn::Mul(set_b(kRounding), hn::Max(z1, set_b(1)));
    auto inside = hn::Ge(nearest, hn::Add(margin, set_b(s.half_voxel)));
    inside = hn::And(hn::AndNot(close, inside), hn::Le(z1, set_b(s.far - 1)));
    dead = hn::Or(dead, hn::Lt(hn::Add(farthest, margin), hn::Zero(b)));

    const auto cell = [b, bu](VB x, int size) HWY_ATTR {
      const VB within = hn::Min(hn::Max(x, hn::Zero(b)), hn::Set(b, static_cast<float>(size - 1)));
      return hn::BitCast(bu, hn::NearestInt(within));
    };
    const auto a0 = cell(u0, s.width), a1 = cell(u1, s.width), b0 = cell(v0, s.height),
               b1 = cell(v1, s.height);
    // Two tiles each way cover the rectangle: the level whose tiles advance by a third of the longer side,
    // from a float's exponent.
    const VB longest = hn::ConvertTo(b, hn::BitCast(bi, hn::Max(hn::Sub(a1, a0), hn::Sub(b1, b0))));
    const VB third = hn::Mul(hn::Max(hn::Sub(longest, set_b(0.5F)), set_b(1)), set_b(1 / 3.0F));
    auto level = hn::Max(hn::BitCast(bi, hn::ShiftRight<23>(hn::BitCast(bu, third))), hn::Set(bi, 127));
    level = hn::Sub(level, hn::Set(bi, 126));
    const auto most = hn::Set(bi, DepthBounds::kLevels);
    const auto too_long = hn::RebindMask(b, hn::Gt(level, most));
    level = hn::Min(level, most);
    const auto start = hn::GatherIndex(bi, s.bounds->start(), level),
               width = hn::GatherIndex(bi, s.bounds->width(), level);
    const auto tile = [bi, level](auto sample) HWY_ATTR { return hn::Shr(hn::BitCast(bi, sample), level); };
    const auto one = hn::Set(bi, 1);
    const auto west = tile(a0), east = hn::Max(west, hn::Sub(tile(a1), one)), upper = tile(b0),
               lower = hn::Max(upper, hn::Sub(tile(b1), one));
    const auto upper_row = hn::Add(start, hn::Mul(upper, width)),
               lower_row = hn::Add(start, hn::Mul(lower, width));
    const auto word = [bu, &s](auto row, auto column)
                          HWY_ATTR { return hn::GatherIndex(bu, s.bounds->words(), hn::Add(row, column)); };
    const auto found = both_bounds(both_bounds(word(upper_row, west), word(upper_row, east)),
                                   both_bounds(word(lower_row, west), word(lower_row, east)));
    const VB front = hn::ConvertTo(b, hn::BitCast(bi, hn::And(found, hn::Set(bu, 0xffffU))));
    const VB back = hn::ConvertTo(b, hn::BitCast(bi, hn::ShiftRight<16>(found)));

    const auto unsure = hn::Or(close, too_long);
    const VB step = set_b(1);  // depths are rounded to steps
    dead = hn::Or(dead, hn::AndNot(unsure, hn::Gt(hn::Sub(z0, step), back)));
    const auto clear = hn::AndNot(unsure, hn::Lt(hn::Add(z1, step), front));
    result.alive |= bits(hn::Not(dead)) << i;
    result.clear |= bits(clear) << i;
    result.inside |= bits(inside) << i;
  }
  constexpr unsigned kAll = (1U << kBoxes) - 1;
  return {result.alive & kAll, result.clear & kAll, result.inside & kAll};
}

}  // namespace
}  // namespace headway::nav::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
