// The cameras of a robot's head as a file (config/hrp2/head.yaml), and the rigs that pairs of them make.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "vision/rig.h"

namespace headway::vision {

/// The head frame is that of the link that carries the cameras: x forward, y left, z up.
struct HeadCamera {
  std::string name;
  CameraIntrinsics intrinsics;
  Eigen::Isometry3d head_from_camera = Eigen::Isometry3d::Identity();
};

struct HeadRig {
  StereoRig rig;
  Eigen::Isometry3d head_from_left = Eigen::Isometry3d::Identity();
};

struct CameraHead {
  std::string name;
  std::vector<HeadCamera> cameras;
  std::vector<HeadRig> rigs;  ///< usable, at least one
};

/// Names of cameras and of rigs are plain file names, each given once. Throws InputError `file:line: key:
/// what, expected what`.
CameraHead read_head(const std::filesystem::path& file);

}  // namespace headway::vision
