// Pictures of what Headway sees and plans: the camera image, depth, uncertainty, the floor with path and
// feet. All are CV_8UC3.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "app/drawing.h"
#include "hal/footstep.h"
#include "hal/frame.h"
#include "nav/body_outline.h"
#include "nav/floor_map.h"
#include "nav/footsteps.h"
#include "nav/planner.h"
#include "nav/walking/gait.h"
#include "vision/range_view.h"

namespace headway::app {

/// The grey image as it is.
cv::Mat image_picture(const hal::GrayImage& image);

/// Depth Z [m] by colour, from the nearest to the farthest 2 % of what was measured within near and far;
/// legend in metres. Unmeasured pixels are dark.
cv::Mat depth_picture(const vision::RangeView& view);

/// sqrt of the largest eigenvalue of each point's covariance, on a logarithmic scale from 1 mm to 1 m.
cv::Mat uncertainty_picture(const vision::RangeView& view);
/// The same value for one pixel [m]; NaN where nothing was measured.
double uncertainty(const vision::RangeView& view, int u, int v);

struct FootPrint {
  Pose2 pose;  ///< map frame
  hal::Foot foot = hal::Foot::kLeft;
  bool committed = false;  ///< drawn filled; others as outlines
};

/// What is drawn over a floor map, all in the map frame [m]. Whatever is empty is not drawn, nor named in the
/// legend.
struct FloorLayers {
  std::vector<Eigen::Vector2d> path, former_path;  ///< polylines
  std::vector<FootPrint> feet;
  std::vector<Eigen::Vector2d> zmp, waist;  ///< along a walk
  std::vector<Pose2> bodies;                ///< base poses: the body's outline with its clearance there
  nav::BodyOutline outline;
  nav::GaitLimits gait;                                 ///< for the size of the soles
  std::vector<Eigen::Vector2d> trail, believed_trail;   ///< of the true base, and of the chest by odometry
  std::vector<std::vector<Eigen::Vector2d>> obstacles;  ///< the truth: closed polygons
  std::vector<Eigen::Vector2d> collisions;
  std::optional<Pose2> start, robot;
  std::optional<Eigen::Vector2d> goal;
  std::optional<double> goal_yaw;  ///< [rad]
  std::string goal_label = "goal";
};

/// A path as a polyline: its start, the centres of its cells, its end.
std::vector<Eigen::Vector2d> polyline(const nav::Path& path, const nav::FloorGrid& grid);
/// The prints of a walk; the first `committed` are marked.
std::vector<FootPrint> foot_prints(const nav::Walk& walk, std::size_t committed = 0);
/// Adds both feet of a stance as committed prints.
void add_stance(const hal::Stance& stance, std::vector<FootPrint>& feet);

struct FloorPictureConfig {
  int least_px = 900;  ///< the longer side of the plan is at least this long
  bool crop = true;    ///< only the part that is known or drawn on, with a margin; else the whole grid
  std::string title;
};

/// The floor from above, x to the right and y up, with axes in metres and a legend.
cv::Mat floor_picture(const nav::FloorMap& floor, const FloorLayers& layers = {},
                      const FloorPictureConfig& config = {});

}  // namespace headway::app
