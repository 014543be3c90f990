// What a rig can see, in space: its field with the points that pixel pairs give, and the fields of several
// rigs. All CV_8UC3.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "app/mesh_files.h"
#include "vision/characterise.h"

namespace headway::app {

/// The points of the pixel pairs, coloured by their resolution on a logarithmic scale; the frame is theirs.
std::vector<ColouredPoint> coloured_points(const vision::Characteristics& rig);

/// The paper's figure 1: those points in space, with the edges of the field's polytope and both cameras.
cv::Mat field_picture(const vision::Characteristics& rig);

/// The field of one of several rigs.
struct NamedField {
  std::string name;
  vision::Polytope field;
  std::vector<Eigen::Vector3d> cameras;  ///< where its cameras are
};
/// Fields of several rigs on one head together; everything in the head's frame (x forward, y left, z up) [m].
cv::Mat fields_picture(const std::vector<NamedField>& fields);

}  // namespace headway::app
