// Whether a filled buffer holds a usable frame, when that was exposed, and how many frames were lost before
// it.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/v4l2_stream.h"
#include "hal/time.h"

namespace headway::drivers {

enum class FrameKind : std::uint8_t {
  kUsable,
  kDamaged,     ///< marked by the driver, or less data than an image has
  kFrozen,      ///< the stamp of the frame before
  kWrongClock,  ///< not monotonic, in the future, before the frame before, or older than two seconds
};

struct FrameVerdict {
  FrameKind kind = FrameKind::kUsable;
  Time exposure{};         ///< its middle
  std::uint64_t lost = 0;  ///< frames missing in the driver's count before this one
};

class FrameJudge {
 public:
  static constexpr Duration kOldest = std::chrono::seconds(2);  ///< poses are kept no longer
  static constexpr Duration kAhead = std::chrono::milliseconds(1);
  /// A count that leaps by more began anew.
  static constexpr std::uint32_t kLargestGap = 1U << 16;

  /// `least`: bytes of a whole frame; `exposure`: how long it takes, zero if nobody knows; `readout`: from
  /// its end to the frame's.
  FrameJudge(std::size_t least, Duration exposure, Duration readout) noexcept
      : least_(least), exposure_(exposure), readout_(readout) {}

  /// Of the next frame; `now`: when it was taken.
  FrameVerdict judge(const FilledBuffer& frame, Time now) noexcept;
  /// The driver's count begins anew.
  void forget_sequence() noexcept { sequence_.reset(); }

 private:
  std::uint64_t gap_before(std::uint32_t sequence) noexcept;
  FrameKind kind_of(const FilledBuffer& frame, Time now) noexcept;
  Time middle_of(const FilledBuffer& frame) const noexcept;

  std::size_t least_;
  Duration exposure_, readout_;
  std::optional<std::uint32_t> sequence_;  ///< of the frame before
  std::optional<Duration> stamp_;          ///< of the last one that could be this clock's
};

}  // namespace headway::drivers
