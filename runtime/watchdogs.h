// How long each thing that a walk rests upon may stay away, and which of them do.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/time.h"

namespace headway::runtime {

/// The graver first.
enum class SafetySource : std::uint8_t {
  kBus,       ///< the CAN bus: on it, and getting frames through
  kControl,   ///< the control computer's status
  kDrives,    ///< the head's drives
  kTime,      ///< the control computer's clock
  kOperator,  ///< the lease of the operator who has control
  kCycles,    ///< the bus loop's own cycles
  kPictures,  ///< pictures that can be used, and the frame loop that works on them
  kMap,       ///< the newest look that told the map something
  kPose,      ///< chest and head, without which no picture has a place
};
inline constexpr std::size_t kSources = 9;

enum class SourceLevel : std::uint8_t {
  kUnused,   ///< not part of this robot or run
  kAwaited,  ///< not heard yet
  kFine,
  kPoor,  ///< later than it should be
  kLost,  ///< stays away
};

struct WatchdogLimits {
  Duration poor{}, lost{};  ///< age above which it is so
  bool awaited = true;      ///< no walk before it was heard; else it counts from when it was first heard
};

/// By SafetySource. Where the drivers have the time-outs of docs/bus.md themselves, as those of the bus (100
/// ms without progress), of the drives' heartbeats (300 ms) and of CTL_Time (5 s), what they say counts at
/// once.
using WatchdogTable = std::array<WatchdogLimits, kSources>;
inline constexpr Duration kSaysItself{0}, kNeverLost = Duration::max();
inline constexpr WatchdogTable kWatchdogs{{
    /* bus      */ {kSaysItself, kSaysItself, true},
    /* control  */ {seconds(0.1), seconds(0.1), true},
    /* drives   */ {kSaysItself, kSaysItself, true},
    /* time     */ {kSaysItself, kSaysItself, false},
    /* operator */ {seconds(1), seconds(1), false},
    /* cycles   */ {kSaysItself, kSaysItself, false},
    /* pictures */ {seconds(1), seconds(3), true},  // a driver starts its camera anew within two
    /* map      */ {seconds(1), seconds(10), true},
    /* pose     */ {seconds(0.1), kNeverLost, true},  // without it the map grows old
}};

const char* name(SafetySource source);
const char* name(SourceLevel level);

/// Real-time safe, and a plain value.
class Watchdogs {
 public:
  explicit Watchdogs(const WatchdogTable& table = kWatchdogs) noexcept : table_(table) {}

  /// It was there at `stamp`. Older stamps than the newest tell nothing.
  void hear(SafetySource source, Time stamp) noexcept;
  /// It says itself how it is, until it says otherwise. Of one with a time-out, only that it is lost counts.
  void say(SafetySource source, SourceLevel level) noexcept { at(source).said = level; }
  /// Judges and counts all of them at `now`. Once a cycle, after what was heard.
  void look(Time now) noexcept;

  SourceLevel level(SafetySource source) const noexcept { return at(source).level; }
  /// Times that it went from better than that to poor, to lost.
  std::uint32_t times_poor(SafetySource source) const noexcept { return at(source).times_poor; }
  std::uint32_t times_lost(SafetySource source) const noexcept { return at(source).times_lost; }

 private:
  struct Watched {
    Time stamp{};
    bool heard = false;
    SourceLevel said = SourceLevel::kUnused, level = SourceLevel::kUnused;
    std::uint32_t times_poor = 0, times_lost = 0;
  };
  Watched& at(SafetySource source) noexcept { return watched_[static_cast<std::size_t>(source)]; }
  const Watched& at(SafetySource source) const noexcept { return watched_[static_cast<std::size_t>(source)]; }
  static SourceLevel judge(const Watched& watched, const WatchdogLimits& limits, Time now) noexcept;

  WatchdogTable table_;
  std::array<Watched, kSources> watched_{};
};

}  // namespace headway::runtime
