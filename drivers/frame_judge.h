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

/// What a camera's frames are measured by.
struct FrameMeasure {
  std::size_t least = 0;  ///< bytes of a whole frame
  Duration exposure{};    ///< how long it takes, zero if nobody knows
  Duration readout{};     ///< from its end to the frame's
};

class FrameJudge {
 public:
  static constexpr Duration kOldest = std::chrono::seconds(2);  ///< poses are kept no longer
  static constexpr Duration kAhead = std::chrono::milliseconds(1);
  /// A count that leaps by more began anew.
  static constexpr std::uint32_t kLargestGap = 1U << 16;

  explicit FrameJudge(const FrameMeasure& measure) noexcept : measure_(measure) {}

  /// Of the next frame; `now`: when it was taken.
  FrameVerdict judge(const FilledBuffer& frame, Time now) noexcept;
  /// Of the same camera, opened anew: still no frame may be older than the one before.
  void measure_by(const FrameMeasure& measure) noexcept { measure_ = measure; }
  /// The driver's count begins anew.
  void forget_sequence() noexcept { sequence_.reset(); }

 private:
  std::uint64_t gap_before(std::uint32_t sequence) noexcept;
  FrameKind kind_of(const FilledBuffer& frame, Time now) noexcept;
  Time middle_of(const FilledBuffer& frame) const noexcept;

  FrameMeasure measure_;
  std::optional<std::uint32_t> sequence_;  ///< of the frame before
  std::optional<Duration> stamp_;          ///< of the last one that could be this clock's
};

}  // namespace headway::drivers
