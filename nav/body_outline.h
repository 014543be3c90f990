// The room the body takes on the floor plan: a rectangle with arms, and the clearance kept around it.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "hal/pose2.h"
#include "nav/floor_map.h"
#include "nav/walking/gait.h"

namespace headway::nav {

/// Seen from above, centred on the base frame. Everything nearer than `clearance()` to the rectangle is
/// touched.
struct BodyOutline {
  double half_depth = 0.20;     ///< along the base's x [m]
  double half_width = 0.31;     ///< along the base's y, arms included [m]
  double sway = 0.03;           ///< how far the body leaves the base while stepping [m]
  double safety_margin = 0.05;  ///< kept free around it [m]

  double clearance() const { return sway + safety_margin; }
  /// No point of the outline is farther from the base than this [m].
  double reach() const { return std::hypot(half_depth, half_width) + clearance(); }
  /// The body alone, nothing kept free around it.
  BodyOutline bare() const { return {half_depth, half_width, 0, 0}; }

  /// Throws InputError `body: key: what, expected what`.
  void validate() const;
};

/// Distance [m] between the body's rectangle at `base` and the axis-parallel square of side `size` [m] around
/// `centre`; 0 when they meet.
double distance_to_square(const BodyOutline& outline, const Pose2& base, const Eigen::Vector2d& centre,
                          double size);

/// Cells of the grid (those inside it) that the outline touches at a base pose, row by row.
std::vector<Eigen::Vector2i> body_cells(const FloorGrid& grid, const BodyOutline& outline, const Pose2& base);

/// Cells of the grid (those inside it) under the print of a sole at a foot's pose, row by row.
std::vector<Eigen::Vector2i> sole_cells(const FloorGrid& grid, const GaitLimits& gait, const Pose2& foot);

}  // namespace headway::nav
