// What the readers of all calibration formats share: opening a file of any tool, matrices, lenses, and faults
// that point at the place in the file that they come from.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "config/yaml_reader.h"
#include "vision/rig.h"

namespace headway::vision {

/// Opens a YAML file, also one that starts with OpenCV's `%YAML:1.0`, which is no YAML. Throws InputError.
config::Section load_calibration(const std::filesystem::path& file);

/// Writes a whole file. Throws InputError when it cannot be opened, Error when there is no room for it.
void write_text(const std::string& text, const std::filesystem::path& file);

/// A mapping of `rows`, `cols` and `data` (OpenCV, ROS, EuRoC), row by row; throws InputError for another
/// shape.
std::vector<double> matrix_of(const config::Section& section, std::string_view key, int rows, int columns);
/// The same with one row or one column of any length up to `most`; nothing in it when its `data` is empty.
std::vector<double> vector_of(const config::Section& section, std::string_view key, std::size_t most);

/// Sets width and height from a list of two whole numbers [px].
void set_size(CameraIntrinsics& camera, const config::Section& section, std::string_view key);

/// From 9 or 16 numbers row by row; `section` and `key` only for the InputError when they are no rotation, no
/// rigid transform. Rounded numbers are made a rotation again.
Eigen::Matrix3d rotation_from(const std::vector<double>& m, const config::Section& section,
                              std::string_view key);
Eigen::Isometry3d transform_from(const std::vector<double>& m, const config::Section& section,
                                 std::string_view key);

/// Sets lens and coefficients, in OpenCV's order: k1 k2 p1 p2 k3 k4 k5 k6 (fisheye: k1 k2 k3 k4). Too few or
/// too many for the lens is an InputError at the key.
void set_lens(CameraIntrinsics& camera, LensModel lens, const std::vector<double>& coefficients,
              const config::Section& section, std::string_view key);
/// The coefficients that the camera's lens has, in that order: 5, 8 or 4.
std::vector<double> coefficients_of(const CameraIntrinsics& camera);

/// Where in the files of a rig its values stand.
struct RigPlaces {
  config::Section left, right, pose;
  std::string size, focal, centre, distortion, transform;
};

/// Throws an InputError that points at the place of what makes the rig unusable.
void require_usable_at(const RigPlaces& places, const StereoRig& rig);

}  // namespace headway::vision
