// The server's own metrics, in Prometheus' text format.
#pragma once

#include <span>
#include <string>

#include "operator/messages.h"
#include "operator/server.h"

namespace headway::remote {

std::string page_metrics(const ServerFigures& figures, std::span<const ViewerStatus> viewers);

}  // namespace headway::remote
