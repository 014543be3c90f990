#include "runtime/watchdogs.h"

#include <algorithm>

namespace headway::runtime {

const char* name(SafetySource source) {
  switch (source) {
    case SafetySource::kBus:
      return "bus";
    case SafetySource::kControl:
      return "control computer";
    case SafetySource::kDrives:
      return "head drives";
    case SafetySource::kTime:
      return "control computer's time";
    case SafetySource::kOperator:
      return "operator";
    case SafetySource::kCycles:
      return "bus cycles";
    case SafetySource::kPictures:
      return "pictures";
    case SafetySource::kMap:
      return "map";
    case SafetySource::kPose:
      return "pose";
  }
  return "?";
}

const char* name(SourceLevel level) {
  switch (level) {
    case SourceLevel::kUnused:
      return "unused";
    case SourceLevel::kAwaited:
      return "awaited";
    case SourceLevel::kFine:
      return "fine";
    case SourceLevel::kPoor:
      return "poor";
    case SourceLevel::kLost:
      return "lost";
  }
  return "?";
}

void Watchdogs::hear(SafetySource source, Time stamp) noexcept {
  Watched& watched = at(source);
  watched.stamp = watched.heard ? std::max(watched.stamp, stamp) : stamp;
  watched.heard = true;
}

SourceLevel Watchdogs::judge(const Watched& watched, const WatchdogLimits& limits, Time now) noexcept {
  if (limits.lost == kSaysItself) {
    const bool begun = watched.said != SourceLevel::kUnused || !limits.awaited;
    return begun ? watched.said : SourceLevel::kAwaited;
  }
  if (!watched.heard) return limits.awaited ? SourceLevel::kAwaited : SourceLevel::kUnused;
  if (watched.said == SourceLevel::kLost) return SourceLevel::kLost;
  const Duration age = now - watched.stamp;
  if (age > limits.lost) return SourceLevel::kLost;
  return age > limits.poor ? SourceLevel::kPoor : SourceLevel::kFine;
}

void Watchdogs::look(Time now) noexcept {
  for (std::size_t i = 0; i < kSources; ++i) {
    Watched& watched = watched_[i];
    const SourceLevel before = watched.level;
    watched.level = judge(watched, table_[i], now);
    if (watched.level == before) continue;
    watched.times_poor += watched.level == SourceLevel::kPoor && before != SourceLevel::kLost;
    watched.times_lost += watched.level == SourceLevel::kLost;
  }
}

}  // namespace headway::runtime
