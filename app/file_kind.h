// What kind of YAML file somebody gave, so that one of the wrong kind is named as what it is and not by the
// first key that it lacks.
#pragma once

#include <filesystem>

namespace headway::app {

enum class FileKind { kRobot, kWorld, kFloorMap };

/// Throws InputError `file: looks like WHAT, expected WHAT` where the file's keys are another kind's, and
/// none of this kind's. Passes over all else, what cannot be read included: the kind's own reader says more.
void require_kind(const std::filesystem::path& file, FileKind expected);

}  // namespace headway::app
