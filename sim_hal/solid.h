// The one kind of thing the simulated world and the robot's body are made of: upright boxes and upright
// cylinders. With both upright, every question about them is a flat one and an interval in height, answered
// exactly.
#pragma once

#include <Eigen/Core>

#include "hal/pose2.h"

namespace headway::sim {

enum class Shape { kBox, kCylinder };

/// An upright box or cylinder. Its own frame has its origin in the solid's centre, x along the length, z up.
struct Solid {
  Shape shape = Shape::kBox;
  Pose2 pose;                    ///< parent_from_solid: where its axis stands [m, rad]
  double bottom = 0, top = 1;    ///< [m] above the floor
  double length = 1, width = 1;  ///< box: along its own x and y [m]
  double radius = 0.5;           ///< cylinder [m]

  static Solid box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, double yaw = 0);
  static Solid cylinder(const Eigen::Vector3d& base, double radius, double height);

  double centre_height() const { return (bottom + top) / 2; }
  /// Radius of the circle about its axis that holds all of it [m].
  double reach() const;
  /// The same solid seen from the parent of `parent`.
  Solid moved(const Pose2& parent) const;
  /// A point of the parent frame in the solid's own frame, and back.
  Eigen::Vector3d to_own(const Eigen::Vector3d& point) const;
  Eigen::Vector3d from_own(const Eigen::Vector3d& point) const;
  /// Is the point inside (the surface counts)?
  bool contains(const Eigen::Vector3d& point) const;
};

/// Do two solids of the same frame share volume? Touching does not count.
bool overlap(const Solid& a, const Solid& b);

/// Distance between the outlines of two solids on the floor, whatever their heights [m]; 0 when they overlap.
double floor_distance(const Solid& a, const Solid& b);

}  // namespace headway::sim
