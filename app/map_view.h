// The voxel map in three dimensions, seen from anywhere: one ray per pixel walks through the bricks.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "app/pictures.h"
#include "hal/pose2.h"
#include "nav/voxel_map.h"

namespace headway::app {

/// Where the picture is taken from, in the map frame [m]; up is +z.
struct Lookout {
  Eigen::Vector3d eye{-3, -3, 3}, target{1, 0, 0.5};
  double field = 0.9;  ///< opening angle over the picture's width [rad]
};

struct MapViewConfig {
  int width = 1000, height = 700;  ///< [px]
  /// Unseen space that borders on empty space, as a translucent veil.
  bool show_unseen = false;
  /// Only the sides of things that were seen, so that one looks into a room through the backs of its walls
  /// and its ceiling. Else every occupied voxel.
  bool seen_sides_only = true;
  /// Voxels outside are not drawn, so that one can look under a ceiling or through a near wall [m].
  Eigen::Vector3d lowest{-1e9, -1e9, -1e9}, highest{1e9, 1e9, 1e9};
  static constexpr double kNoFloor = std::numeric_limits<double>::quiet_NaN();
  double floor_height = 0;  ///< where figures stand and floor marks lie [m]; kNoFloor: it is not known where
  /// Heights that the colours span [m]; what is lower or higher has the end's colour.
  double colour_lowest = 0, colour_highest = 2.0;
  std::string title;
};

/// What is put into the picture beside the map, in the map frame.
struct MapFigures {
  std::optional<Pose2> robot;  ///< a figure of simple boxes of HRP-2's height
  std::optional<Eigen::Vector2d> goal;
  std::vector<Eigen::Vector2d> path;  ///< on the floor
  std::vector<FootPrint> feet;        ///< on the floor
  nav::GaitLimits gait;
};

/// CV_8UC3. Occupied voxels are shaded by the face seen and coloured by height.
cv::Mat map_view(const nav::VoxelMap& map, const Lookout& from, const MapViewConfig& config = {},
                 const MapFigures& figures = {});

/// A bird's view of all that is occupied, within the limits of `config`, and of the figures, from the
/// direction `azimuth` [rad] (where the eye stands, counter-clockwise from +x) and `elevation` above the
/// horizon [rad].
Lookout bird_view(const nav::VoxelMap& map, const MapViewConfig& config, double azimuth = -2.3,
                  double elevation = 0.75, const MapFigures& figures = {});

}  // namespace headway::app
