// Rigs from files of many tools, and back: our own YAML, ROS, Kalibr, OpenCV, EuRoC.
#pragma once

#include <filesystem>

#include "vision/rig_formats.h"

namespace headway::vision {

/// Reads a calibration and finds out whose it is. `path` is
/// - one file: our own YAML, Kalibr's camchain, OpenCV's yml with everything in it;
/// - two, separated by a comma: `left.yaml,right.yaml` (ROS camera_info, EuRoC's sensor.yaml) or
///   `intrinsics.yml,extrinsics.yml` (OpenCV);
/// - a folder that holds rig.yaml (one file, as above), left.yaml and right.yaml, cam0/sensor.yaml and
///   cam1/sensor.yaml, or intrinsics.yml and extrinsics.yml.
/// Throws InputError `file:line: key: what, expected what` for what it cannot read or what is no usable rig.
StereoRig read_rig(const std::filesystem::path& path, const RigDefaults& defaults = {});

/// The calibration in the folder of an EuRoC sequence.
StereoRig read_euroc_rig(const std::filesystem::path& dir, const RigDefaults& defaults = {});

/// Writes a rig as `read_rig` reads it back: every number to the last bit, the rotation to 1e-12. Throws
/// InputError for an unusable rig and for a file that cannot be written.
void write_rig(const StereoRig& rig, const std::filesystem::path& file);

/// Writes ROS camera_info of both cameras, as camera_calibration does: with our rectification, and a camera
/// matrix to the last bit. What ROS has no key for is lost: depth limits and disparity_sigma. Throws as
/// `write_rig` does.
void write_camera_info(const StereoRig& rig, const std::filesystem::path& left,
                       const std::filesystem::path& right);

}  // namespace headway::vision
