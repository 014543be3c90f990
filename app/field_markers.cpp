#include "app/field_markers.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "vision/resolution.h"
#include "vision/rig_polytope.h"

namespace headway::app {

namespace {

namespace ros = remote::ros;

/// The corners on a row's plane, around their middle, counter-clockwise as seen from outside.
std::vector<Eigen::Vector3d> face(const vision::Polytope& polytope, const Eigen::Vector4d& row) {
  constexpr double kOnPlane = 1e-6;  // [m]
  std::vector<Eigen::Vector3d> corners;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& c : polytope.corners)
    if (std::abs(vision::side(row, c.x(), c.y(), c.z())) < kOnPlane) {
      corners.push_back(c);
      middle += c;
    }
  if (corners.size() < 3) return {};
  middle /= static_cast<double>(corners.size());
  const Eigen::Vector3d outward = -row.head<3>().normalized();
  const Eigen::Vector3d x = (corners.front() - middle).normalized(), y = outward.cross(x);
  std::ranges::sort(corners, {}, [&](const Eigen::Vector3d& c) {
    return std::atan2(y.dot(c - middle), x.dot(c - middle));
  });
  return corners;
}

ros::Marker marker(const vision::Polytope& polytope, std::string name, const ros::ColorRgba& colour) {
  ros::Marker out;
  out.header.frame_id = "camera_left";
  out.ns = std::move(name);
  out.type = ros::Marker::kTriangleList;
  out.pose.orientation.w = 1;
  out.color = colour;
  for (const Eigen::Vector3d& p : triangles(polytope)) out.points.push_back({p.x(), p.y(), p.z()});
  return out;
}

}  // namespace

std::vector<Eigen::Vector3d> triangles(const vision::Polytope& polytope) {
  std::vector<Eigen::Vector3d> all;
  for (const Eigen::Vector4d& row : polytope.rows) {
    const std::vector<Eigen::Vector3d> corners = face(polytope, row);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i)
      all.insert(all.end(), {corners[0], corners[i], corners[i + 1]});
  }
  return all;
}

ros::MarkerArray field_markers(const vision::StereoRig& rig, const vision::VisionConfig& config) {
  const vision::RectifiedRig rectified = vision::Rectifier(rig, config.scale).rig();
  const vision::Polytope field =
      vision::rig_polytope(rectified, {.near = rig.nearest, .far = rig.farthest, .blind_columns = 0});
  ros::MarkerArray all;
  all.markers.push_back(marker(field, "rig", {0.9F, 0.9F, 0.9F, 0.12F}));
  for (const int mm : {5, 10, 20, 50})
    if (const auto resolved = vision::resolution_polytope(rectified, field, mm / 1000.0))
      all.markers.push_back(marker(*resolved, fmt::format("{} mm", mm), {0.0F, 0.6F, 0.5F, 0.18F}));
  return all;
}

}  // namespace headway::app
