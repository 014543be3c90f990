// Pictures of what a rig can see, before it has seen anything: its field with all points that pixel pairs
// give, sections coloured by resolution, plots over depth, and what a tour of the head covers. All CV_8UC3.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "app/mesh_files.h"
#include "hal/head_kinematics.h"
#include "vision/characterise.h"

namespace headway::app {

/// The points of the pixel pairs, coloured by their resolution on a logarithmic scale; the frame is theirs.
std::vector<ColouredPoint> coloured_points(const vision::Characteristics& rig);

/// The paper's figure 1: those points in space, with the edges of the field's polytope and both cameras.
cv::Mat field_picture(const vision::Characteristics& rig);

/// Sections through the field from above and from the side: resolution by colour, and the outlines of the
/// polytopes for a resolution.
cv::Mat sections_picture(const vision::Characteristics& rig);

/// Resolution over depth: on the axis and in the worst corner as the formula has it, and as measured.
cv::Mat resolution_plot(const vision::Characteristics& rig);

/// Opening angles of the common view over depth, beside the paper's 33 x 33 deg.
cv::Mat angles_plot(const vision::RectifiedRig& rig);

/// The field of one of several rigs.
struct NamedField {
  std::string name;
  vision::Polytope field;
  std::vector<Eigen::Vector3d> cameras;  ///< where its cameras are
};
/// Fields of several rigs on one head together; everything in the head's frame (x forward, y left, z up) [m].
cv::Mat fields_picture(const std::vector<NamedField>& fields);

/// A head that looks in some directions, and how that is named below the picture.
struct Tour {
  std::vector<hal::HeadAngles> views;
  double distance = 0;  ///< of what is looked at [m]
  std::string caption;
};
/// Directions around the neck: how many views show each, and what the head could show but these views do not.
/// `field` has no depth limits and is in the frame that `neck` leads to.
cv::Mat tours_picture(const vision::Polytope& field, const hal::HeadKinematics& neck,
                      const hal::HeadLimits& limits, const std::vector<Tour>& tours);

}  // namespace headway::app
