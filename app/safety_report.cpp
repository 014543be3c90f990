#include "app/safety_report.h"

namespace headway::app {

Json safety_json(const runtime::SafetyReport& safety) {
  Json sources;
  for (std::size_t i = 0; i < runtime::kSources; ++i) {
    const auto source = static_cast<runtime::SafetySource>(i);
    const auto& watch = safety.of(source);
    sources[name(source)] = {{"level", name(watch.level)}, {"poor", watch.poor}, {"lost", watch.lost}};
  }
  return {{"state", name(safety.state)},
          {"reason", describe(safety)},
          {"stops", safety.stops},
          {"sources", std::move(sources)}};
}

}  // namespace headway::app
