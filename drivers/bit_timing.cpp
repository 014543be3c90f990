#include "drivers/bit_timing.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace headway::drivers {

namespace {

/// Longer segments than any controller has; keeps the search short whatever a device says of itself.
constexpr std::uint32_t kLongestSegment = 1024;

bool are_plausible(const BitTimingLimits& l) noexcept {
  return l.tseg1_min <= l.tseg1_max && l.tseg1_max >= 2 && l.tseg1_max <= kLongestSegment &&
         l.tseg2_min <= l.tseg2_max && l.tseg2_max >= 1 && l.tseg2_max <= kLongestSegment && l.sjw_max >= 1 &&
         l.brp_min >= 1 && l.brp_min <= l.brp_max && l.brp_increment >= 1;
}

/// Of the prescalers that the controller has, the largest up to `wanted`.
std::uint32_t prescaler_below(const BitTimingLimits& l, double wanted) noexcept {
  const double bounded = std::clamp<double>(wanted, l.brp_min, l.brp_max);
  const auto whole = static_cast<std::uint32_t>(bounded);
  return whole - (whole - l.brp_min) % l.brp_increment;
}

/// A bit of `quanta` quanta that is sampled as near to the sample point as the limits allow.
BitTiming divide(const BitTimingLimits& l, std::uint32_t quanta, std::uint32_t brp,
                 double sample_point) noexcept {
  const std::uint32_t most = std::min(l.tseg2_max, quanta - 1 - std::max(l.tseg1_min, 2u));
  const std::uint32_t least =
      std::max({l.tseg2_min, 1u, quanta - 1 > l.tseg1_max ? quanta - 1 - l.tseg1_max : 0u});
  const auto wanted = static_cast<std::uint32_t>(std::lround(quanta * (1 - sample_point)));
  BitTiming t{.phase_seg2 = std::clamp(wanted, least, std::max(least, most)), .brp = brp};
  const std::uint32_t tseg1 = quanta - 1 - t.phase_seg2;
  t.prop_seg = tseg1 / 2;
  t.phase_seg1 = tseg1 - t.prop_seg;
  t.sjw = std::clamp(t.phase_seg2 / 2, 1u, l.sjw_max);
  return t;
}

}  // namespace

std::optional<BitTiming> find_bit_timing(const BitTimingLimits& limits, std::uint32_t clock_hz,
                                         std::uint32_t bitrate, double sample_point) noexcept {
  if (!are_plausible(limits) || clock_hz == 0 || bitrate == 0) return std::nullopt;
  using Badness = std::tuple<double, double, std::uint32_t>;
  Badness least{kBitRateTolerance * bitrate, 1.0, 0xFFFFFFFF};
  std::optional<BitTiming> best;
  const std::uint32_t fewest = 1 + std::max(limits.tseg1_min, 2u) + std::max(limits.tseg2_min, 1u);
  for (std::uint32_t quanta = fewest; quanta <= 1 + limits.tseg1_max + limits.tseg2_max; ++quanta) {
    const std::uint32_t below = prescaler_below(limits, clock_hz / (1.0 * quanta * bitrate));
    const bool is_last = limits.brp_max - below < limits.brp_increment;
    for (const std::uint32_t brp : {below, is_last ? below : below + limits.brp_increment}) {
      const BitTiming t = divide(limits, quanta, brp, sample_point);
      const Badness badness{std::abs(t.bitrate(clock_hz) - bitrate),
                            std::abs(t.sample_point() - sample_point), t.brp};
      if (badness > least) continue;
      least = badness;
      best = t;
    }
  }
  return best;
}

}  // namespace headway::drivers
