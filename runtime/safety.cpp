#include "runtime/safety.h"

#include <type_traits>

namespace headway::runtime {

static_assert(std::is_trivially_copyable_v<Safety> && std::is_trivially_copyable_v<Watchdogs>);

namespace {

constexpr bool is_sight(SafetySource source) {
  return source == SafetySource::kPictures || source == SafetySource::kMap;
}

/// The first source, the graver first, that is so.
template <class Test>
std::optional<SafetySource> first(const Watchdogs& watchdogs, Test test) noexcept {
  for (std::size_t i = 0; i < kSources; ++i)
    if (const auto source = static_cast<SafetySource>(i); test(source, watchdogs.level(source)))
      return source;
  return std::nullopt;
}

}  // namespace

const char* name(SafetyState state) {
  switch (state) {
    case SafetyState::kInit:
      return "init";
    case SafetyState::kReady:
      return "ready";
    case SafetyState::kActive:
      return "active";
    case SafetyState::kDegraded:
      return "degraded";
    case SafetyState::kSafeStop:
      return "safe stop";
    case SafetyState::kFault:
      return "fault";
  }
  return "?";
}

const char* name(SafetyEvent event) {
  switch (event) {
    case SafetyEvent::kReset:
      return "reset";
    case SafetyEvent::kFault:
      return "the control computer reports a fault";
    case SafetyEvent::kStopAsked:
      return "asked to stop";
    case SafetyEvent::kLost:
      return "lost";
    case SafetyEvent::kBlind:
      return "too old";
    case SafetyEvent::kPoor:
      return "late";
    case SafetyEvent::kFine:
      return "everything is there";
    case SafetyEvent::kIdle:
      return "no goal";
    case SafetyEvent::kOrdered:
      return "a goal was given";
  }
  return "?";
}

std::string describe(const SafetyReport& report) {
  if (!report.source) return name(report.event);
  const bool awaited = report.of(*report.source).level == SourceLevel::kAwaited;
  return std::string(name(*report.source)) + " " + (awaited ? "not heard yet" : name(report.event));
}

void Safety::take(SafetyEvent event, std::optional<SafetySource> source) noexcept {
  const SafetyState next = next_state(table_, report_.state, event);
  const bool waits = next == SafetyState::kInit && event == SafetyEvent::kPoor;  // for what, may change
  if (next == report_.state && !waits) return;
  if (stopped(next)) ++report_.stops;
  report_.state = next;
  report_.event = event;
  report_.source = source;
}

void Safety::cycle(const SafetyInput& input, const Watchdogs& watchdogs) noexcept {
  const auto lost = first(watchdogs, [](SafetySource s, SourceLevel level) {
    return level == SourceLevel::kLost && !is_sight(s);
  });
  const auto blind = first(watchdogs, [](SafetySource s, SourceLevel level) {
    return level == SourceLevel::kLost && is_sight(s);
  });
  const auto poor = first(watchdogs, [](SafetySource, SourceLevel level) {
    return level != SourceLevel::kFine && level != SourceLevel::kUnused;
  });
  if (input.reset && !input.fault) take(SafetyEvent::kReset);
  if (input.fault) take(SafetyEvent::kFault);
  const std::uint32_t stops = report_.stops;
  if (input.stop_asked || input.ends) take(SafetyEvent::kStopAsked);
  // Whatever the state, a goal that is on its way here was given before it.
  if (input.stop_asked && report_.stops == stops) ++report_.stops;
  if (lost) take(SafetyEvent::kLost, lost);
  // A goal that waits, or is given meanwhile, is void as well.
  const bool hard = input.fault || input.ends || lost;
  if (hard && input.goal && input.goal_after == report_.stops) ++report_.stops;
  if (blind) take(SafetyEvent::kBlind, blind);
  poor ? take(SafetyEvent::kPoor, poor) : take(SafetyEvent::kFine);
  const bool ordered = input.goal && input.goal_after == report_.stops;
  take(ordered ? SafetyEvent::kOrdered : SafetyEvent::kIdle);
  for (std::size_t i = 0; i < kSources; ++i) {
    const auto source = static_cast<SafetySource>(i);
    report_.sources[i] = {watchdogs.level(source), watchdogs.times_poor(source),
                          watchdogs.times_lost(source)};
  }
}

}  // namespace headway::runtime
