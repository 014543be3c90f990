#include "operator/page_metrics.h"

#include <cstdint>

#include <fmt/format.h>

namespace headway::remote {

std::string page_metrics(const ServerFigures& figures, std::span<const ViewerStatus> viewers) {
  std::string text;
  const auto add = [&](const char* name, const char* type, const char* help, std::uint64_t value) {
    text += fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n{0} {3}\n", name, help, type, value);
  };
  add("headway_page_viewers", "gauge", "Viewers of the operator's page.", figures.clients);
  add("headway_page_messages_total", "counter", "Messages sent to viewers.", figures.messages);
  add("headway_page_missed_total", "counter", "Messages that viewers were too slow for.", figures.dropped);
  add("headway_page_calls_total", "counter", "Calls of services.", figures.calls);
  add("headway_page_refused_total", "counter", "Requests and connections that were turned away.",
      figures.refused);
  if (viewers.empty()) return text;
  constexpr const char* kMissed = "headway_page_viewer_missed";
  text += fmt::format("# HELP {0} Messages that a viewer was too slow for.\n# TYPE {0} gauge\n", kMissed);
  for (const ViewerStatus& viewer : viewers)
    text += fmt::format("{}{{viewer=\"{}\",role=\"{}\",address=\"{}\"}} {}\n", kMissed, viewer.number,
                        viewer.role, viewer.address, viewer.missed);
  return text;
}

}  // namespace headway::remote
