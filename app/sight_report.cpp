#include "app/sight_report.h"

#include <fmt/format.h>

#include "app/standard_streams.h"
#include "hal/error.h"

namespace headway::app {

namespace {

Json camera(const vision::CameraSight& sight) {
  return {{"brightness", rounded(sight.brightness, 1)},
          {"black", rounded(sight.black)},
          {"white", rounded(sight.white)},
          {"texture", rounded(sight.texture)},
          {"sharpness", rounded(sight.sharpness)}};
}

}  // namespace

const char* name(vision::Severity severity) {
  return severity == vision::Severity::kFault ? "fault" : "warning";
}

Json sight_report(const vision::SightReport& sight) {
  Json findings = Json::array();
  for (const vision::SightFinding& finding : sight.findings) {
    findings.push_back({{"severity", name(finding.severity)}, {"what", finding.what}});
  }
  return {{"left", camera(sight.left)},
          {"right", camera(sight.right)},
          {"pieces_looked_for", sight.pair.looked_for},
          {"pieces_found", sight.pair.found},
          {"row_error_px", rounded(sight.pair.row_error, 3)},
          {"row_offset_px", rounded(sight.pair.row_offset, 3)},
          {"behind_infinity", rounded(sight.pair.behind_infinity)},
          {"findings", findings}};
}

void require_two_images(const hal::StereoFrame& frame, const std::filesystem::path& left,
                        const std::filesystem::path& right) {
  if (frame.left.pixels != frame.right.pixels) return;
  throw InputError(
      fmt::format("{}, {}: both images are the same, expected one of the left and one of the right camera",
                  left.string(), right.string()));
}

void print_findings(const vision::SightReport& sight, const std::filesystem::path& left,
                    const std::filesystem::path& right) {
  for (const vision::SightFinding& finding : sight.findings)
    say_error("headway: {}, {}: {}\n", left.string(), right.string(), finding.what);
}

}  // namespace headway::app
