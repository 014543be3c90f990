// What a rig sees and how precisely, together with what the robot's head makes of it: all that the command
// characterise tells, writes and draws.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/robot_file.h"
#include "vision/characterise.h"

namespace headway::app {

inline constexpr double kFarAway = 1e6;  // [m] as good as infinity

/// A tour of the head and how much it shows, far away and at one metre.
struct CoveredTour {
  std::string laid_out_for;
  std::vector<hal::HeadAngles> views;
  vision::CoveredShares far_away, at_a_metre;
};

struct Characterisation {
  vision::StereoRig raw;
  Robot robot;  ///< its camera sits where the rig does
  vision::Characteristics rig;
  Eigen::Isometry3d left_from_rectified = Eigen::Isometry3d::Identity();
  vision::Polytope endless;        ///< the field without depth limits, in the raw left camera's frame
  std::vector<CoveredTour> tours;  ///< the first is laid out for the paper's field of view
};

/// `tilt_from_left`: where the rig's left camera sits, unless that is where the robot's own one does. Throws
/// InputError for unusable rigs and robot files.
Characterisation characterised(const vision::StereoRig& rig, const std::filesystem::path& robot,
                               const std::vector<double>& resolutions,
                               const std::optional<Eigen::Isometry3d>& tilt_from_left = std::nullopt);

/// Depths worth a column: the rig's limits, round ones between and around them, and kFarAway.
std::vector<double> telling_depths(const vision::StereoRig& rig);

}  // namespace headway::app
