// What a running program answers to those who look at it or send it somewhere: a line of JSON each way.
#pragma once

#include <string>
#include <string_view>

#include "app/live_session.h"
#include "app/report.h"

namespace headway::app {

/// How it is, for the operator.
Json status_json(const LiveSession& session, const LiveStatus& status, Time now);
/// The same for a person, some lines of text.
std::string status_text(const Json& status);
/// The same in Prometheus' text exposition format 0.0.4.
std::string status_metrics(const Json& status);

/// Does what a line asks for and says how that went: {"ok": true, ...} or {"ok": false, "error": "..."}.
/// Questions: {"do": "status"}, {"do": "go", "to": [x, y], "yaw_deg": a, "near": false, "from": "robot" or
/// "map"},
/// {"do": "stay"}, {"do": "reset"}. Never throws.
std::string answer(std::string_view question, LiveSession& session, const LiveStatus& status, Time now);

}  // namespace headway::app
