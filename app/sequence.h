// Recorded sequences from folders: stereo pairs as EuRoC keeps them, or depth images with a pose each.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/time.h"
#include "vision/range_view.h"
#include "vision/rig.h"

namespace headway::app {

/// Where a frame's pose comes from.
enum class PoseSource {
  kGiven,         ///< the frame has its own
  kInterpolated,  ///< between two poses, at the frame's stamp
  kNearest,       ///< outside the recorded poses, but the camera stands still there: the nearest one
};
const char* describe(PoseSource source);

struct SequenceFrame {
  std::string name;             ///< as its file is called
  Time stamp{};                 ///< since the first frame
  std::filesystem::path left;   ///< or the depth image
  std::filesystem::path right;  ///< empty for depth images
  Eigen::Isometry3d world_from_camera =
      Eigen::Isometry3d::Identity();  ///< raw left (or depth) camera, optical frame
  PoseSource pose_source = PoseSource::kGiven;
};

struct Sequence {
  enum class Layout { kStereo, kDepth } layout = Layout::kStereo;
  std::vector<SequenceFrame> frames;     ///< in order of time; at least one
  std::optional<vision::StereoRig> rig;  ///< kStereo
  vision::PinholeCamera camera;          ///< kDepth; size from the first image
  bool world_is_level = false;           ///< the poses' z axis is known to point up
  std::vector<std::string> skipped;      ///< frames left out, each with its reason
};

struct SequenceOptions {
  std::optional<std::filesystem::path> rig;  ///< a rig file in place of cam0/ and cam1/sensor.yaml
  double still_m = 0.05, still_rad = 0.03;   ///< what counts as standing still over the poses near the gap
};

/// Recognises the layout and reads everything but the images. Throws InputError `file:line: what, expected
/// what` on a missing folder, no pairs, unequal numbers of images, or malformed poses, intrinsics or
/// calibration.
Sequence read_sequence(const std::filesystem::path& folder, const SequenceOptions& options = {});

/// The two layouts by themselves.
Sequence read_stereo_sequence(const std::filesystem::path& folder, const SequenceOptions& options = {});
Sequence read_depth_sequence(const std::filesystem::path& folder);

/// A pose with its stamp [ns], in rising order.
struct StampedPose {
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};
/// "stamp [ns], x, y, z, qw, qx, qy, qz" a line; # begins a comment. Throws InputError.
std::vector<StampedPose> read_pose_table(const std::filesystem::path& csv);

/// A 4x4 rigid transform. Throws InputError when it is not one.
Eigen::Isometry3d read_pose_matrix(const std::filesystem::path& file);

/// A 3x3 pinhole matrix with square pixels; the size is left at zero. Throws InputError.
vision::PinholeCamera read_intrinsics(const std::filesystem::path& file);

}  // namespace headway::app
