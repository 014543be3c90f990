// What a report says of how the cameras see.
#pragma once

#include <filesystem>

#include "app/report.h"
#include "vision/sight_check.h"

namespace headway::app {

const char* name(vision::Severity severity);

/// The numbers behind a judgement, and what was found wrong: `findings` is empty for a healthy pair.
Json sight_report(const vision::SightReport& sight);

/// One line to stderr for each thing found wrong with the pair in these files.
void print_findings(const vision::SightReport& sight, const std::filesystem::path& left,
                    const std::filesystem::path& right);

/// Throws InputError where somebody gave one image for both cameras.
void require_two_images(const hal::StereoFrame& frame, const std::filesystem::path& left,
                        const std::filesystem::path& right);

}  // namespace headway::app
