// What a standing robot stands on: the convex hull of the soles on the floor.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "hal/pose2.h"

namespace headway::nav {

class SupportPolygon {
 public:
  /// One sole: `length` x `width` [m], centred on the foot's frame.
  SupportPolygon(const Pose2& foot, double length, double width);
  /// The hull of two.
  SupportPolygon(const Pose2& left, const Pose2& right, double length, double width);

  /// Distance to the nearest edge's line [m]: positive inside, negative outside.
  double margin(const Eigen::Vector2d& point) const;
  std::size_t size() const { return size_; }
  const Eigen::Vector2d& corner(std::size_t i) const { return corners_[i]; }

 private:
  std::array<Eigen::Vector2d, 8> corners_;  ///< counter-clockwise
  std::size_t size_ = 0;
};

}  // namespace headway::nav
