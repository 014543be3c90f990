// Poses and intrinsics from text files, checked: what is malformed is named by file and line.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "vision/head_calibration.h"
#include "vision/range_view.h"

namespace headway::app {

/// A pose with its stamp [ns], in rising order.
struct StampedPose {
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};
/// "stamp [ns], x, y, z, qw, qx, qy, qz" a line; # begins a comment. Throws InputError.
std::vector<StampedPose> read_pose_table(const std::filesystem::path& csv);

/// "stamp [s] x y z qx qy qz qw" a line, as TUM's RGB-D sequences have it, in rising order. Throws
/// InputError.
std::vector<StampedPose> read_tum_poses(const std::filesystem::path& file);

/// An image with its stamp [ns].
struct StampedImage {
  std::int64_t stamp_ns = 0;
  std::filesystem::path image;
};
/// The depth images of a TUM list: "stamp [s] file" a line, or such pairs of depth and colour beside each
/// other, the depth image's named depth/... Paths are relative to the list. Throws InputError.
std::vector<StampedImage> read_tum_images(const std::filesystem::path& file);

/// "stamp [ns], pan [deg], tilt [deg]" a line, as the drives report them, in rising order; # begins a
/// comment. Throws InputError.
std::vector<vision::HeadSample> read_head_table(const std::filesystem::path& csv);

/// The stamp that an image is named by, as 1403715273262142976.png [ns]. Throws InputError.
std::int64_t stamp_of_image(const std::filesystem::path& image);

/// A 4x4 rigid transform. Throws InputError when it is not one.
Eigen::Isometry3d read_pose_matrix(const std::filesystem::path& file);

/// A 3x3 pinhole matrix with square pixels; the size is left at zero. Throws InputError.
vision::PinholeCamera read_intrinsics(const std::filesystem::path& file);

}  // namespace headway::app
