// Recorded sequences from folders: stereo pairs as EuRoC keeps them, or depth images with poses, each its own
// or in a table as TUM and ICL-NUIM keep them.
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
  double depth_per_metre = 1000;         ///< kDepth; units of the images
  bool world_is_level = false;           ///< the poses' z axis is known to point up
  bool rotations_inverted = false;       ///< the pose table's rotations were read as camera from world
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

/// The layouts by themselves.
Sequence read_stereo_sequence(const std::filesystem::path& folder, const SequenceOptions& options = {});
Sequence read_depth_sequence(const std::filesystem::path& folder);
/// groundtruth.txt, associations.txt or depth.txt, and camera-intrinsics.txt. Without the last the images
/// must be ICL-NUIM's, whose stamps are whole numbers and whose camera is known.
Sequence read_tum_sequence(const std::filesystem::path& folder, const SequenceOptions& options = {});

}  // namespace headway::app
