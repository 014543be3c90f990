// Rigs from files: our own YAML, and the calibration folders of EuRoC sequences.
#pragma once

#include <filesystem>

#include "config/yaml_reader.h"
#include "vision/rig.h"

namespace headway::vision {

/// Reads a rig file (config/hrp2/rigs/bottom.yaml shows all keys). Throws InputError `file:line: key: ...`.
StereoRig read_rig(const std::filesystem::path& file);

/// The same from a section of another file; keys are marked as read, the caller calls `finish`.
StereoRig rig_from(const config::Section& section);

/// Writes a rig as `read_rig` reads it back: every number to the last bit, the rotation to 1e-12. Throws
/// InputError for an unusable rig and for a file that cannot be written.
void write_rig(const StereoRig& rig, const std::filesystem::path& file);

/// Depth limits for rigs whose files do not say any [m].
struct DepthLimits {
  double nearest = 0.8, farthest = 8.0;
};

/// Reads `dir`/cam0/sensor.yaml (left) and `dir`/cam1/sensor.yaml (right): intrinsics fu fv cu cv,
/// radial-tangential distortion, T_BS (body from sensor). Throws InputError.
StereoRig read_euroc_rig(const std::filesystem::path& dir, const DepthLimits& limits = {});

}  // namespace headway::vision
