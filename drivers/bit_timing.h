// How a CAN controller divides its clock into bits: the search for the segments that give a bit rate and a
// sample point, within what the controller can do.
#pragma once

#include <cstdint>
#include <optional>

namespace headway::drivers {

/// What a controller can do. Segments in time quanta, both ends included; a quantum is `brp` periods of its
/// clock.
struct BitTimingLimits {
  std::uint32_t tseg1_min = 0, tseg1_max = 0;  ///< propagation segment and phase segment 1 together
  std::uint32_t tseg2_min = 0, tseg2_max = 0;  ///< phase segment 2
  std::uint32_t sjw_max = 0;                   ///< synchronisation jump width
  std::uint32_t brp_min = 0, brp_max = 0, brp_increment = 0;

  bool operator==(const BitTimingLimits&) const = default;
};

/// One bit (ISO 11898-1): a quantum to synchronise, prop_seg, phase_seg1, the sample point, phase_seg2.
struct BitTiming {
  std::uint32_t prop_seg = 0, phase_seg1 = 0, phase_seg2 = 0, sjw = 0, brp = 0;

  std::uint32_t quanta() const noexcept { return 1 + prop_seg + phase_seg1 + phase_seg2; }
  double bitrate(std::uint32_t clock_hz) const noexcept {  ///< [bit/s]
    return static_cast<double>(clock_hz) / (static_cast<double>(brp) * quanta());
  }
  double sample_point() const noexcept {  ///< fraction of the bit
    return static_cast<double>(quanta() - phase_seg2) / quanta();
  }

  bool operator==(const BitTiming&) const = default;
};

/// More than this off the bit rate and two nodes lose each other within a frame (relative).
constexpr double kBitRateTolerance = 0.005;

/// The timing nearest to the bit rate [bit/s]; of several, that nearest to the sample point (0..1); of these,
/// the one with the most quanta. Nothing when the tolerance cannot be kept, or the limits are those of no
/// controller.
std::optional<BitTiming> find_bit_timing(const BitTimingLimits& limits, std::uint32_t clock_hz,
                                         std::uint32_t bitrate, double sample_point) noexcept;

}  // namespace headway::drivers
