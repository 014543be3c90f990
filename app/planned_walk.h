// A walk on a floor map from stance to goal, all of it before the first step: path, feet, and what the
// walking pattern makes of them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "app/pictures.h"
#include "app/report.h"
#include "app/robot_file.h"
#include "nav/footsteps.h"
#include "nav/planner.h"
#include "nav/walking/forecast.h"

namespace headway::app {

struct PlannedWalk {
  Pose2 start;
  nav::Goal goal;
  nav::PlanResult plan;
  nav::Walk walk;  ///< empty without a path
  std::optional<nav::Forecast>
      forecast;  ///< nothing without a path, or when the pattern does not take a step
  // At each period of the pattern:
  std::vector<Eigen::Vector2d> waist, zmp;  ///< [m]
  std::vector<double> margin;               ///< of the ZMP inside the soles [m]
  double period = 0;                        ///< [s]
};

/// From a stance with parallel feet at `start`.
PlannedWalk plan_walk(const Robot& robot, const nav::FloorMap& floor, const Pose2& start,
                      const nav::Goal& goal);

/// Why it cannot be walked; empty when it can.
std::string complaint(const PlannedWalk& walk, const nav::GaitLimits& gait);

/// Path, steps and costs; angles in degrees.
Json report_of(const PlannedWalk& walk, const Robot& robot, const nav::FloorGrid& grid);

/// All of it, over the floor.
FloorLayers layers_of(const PlannedWalk& walk, const Robot& robot, const nav::FloorGrid& grid);

/// How far the ZMP is inside the soles, over time.
cv::Mat zmp_picture(const PlannedWalk& walk, const nav::GaitLimits& gait);

}  // namespace headway::app
