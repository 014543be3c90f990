// What stands beside the map in a 3D view: the robot and the goal as boxes, path and feet as marks on the
// floor.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "app/map_view.h"

namespace headway::app {

/// Where a ray meets something, and what it looks like there.
struct FigureHit {
  double t = 0;  ///< distance from the eye [m]
  Colour colour;
};

/// Boxes in frames of their own.
class FigureBoxes {
 public:
  FigureBoxes(const MapFigures& figures, double floor_height);
  std::optional<FigureHit> meet(const Eigen::Vector3d& eye, const Eigen::Vector3d& direction) const;

 private:
  struct Box {
    Eigen::AlignedBox3d extent;
    Colour colour;
  };
  struct Group {
    Eigen::Isometry3d group_from_map;
    Eigen::AlignedBox3d extent;
    std::vector<Box> boxes;
  };
  void add(const Eigen::Isometry3d& map_from_group, std::vector<Box> boxes);
  std::vector<Group> groups_;
};

/// A picture that lies on the floor.
class FloorMarks {
 public:
  FloorMarks(const MapFigures& figures);
  /// The colour of the marks there, if any.
  std::optional<Colour> at(const Eigen::Vector2d& point) const;

 private:
  Eigen::Vector2d lowest_{0, 0};
  cv::Mat3b colours_;
  cv::Mat1b drawn_;
};

}  // namespace headway::app
