#include "app/rig_plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "app/plot.h"
#include "app/resolution_scale.h"
#include "hal/angle.h"
#include "vision/hull.h"

namespace headway::app {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPaperField = 33;  // [deg], each way

/// Where a plane cuts the hull of some corners: a convex outline, in coordinates (`a`, `b`) of the plane.
std::vector<Vector2d> section(const std::vector<Vector3d>& corners, int across, double at, int a, int b,
                              double sign_b) {
  const vision::TriangleMesh mesh = vision::hull_mesh(corners);
  std::vector<cv::Point2f> cut;
  for (const auto& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d &p = mesh.corners[t[i]], &q = mesh.corners[t[(i + 1) % 3]];
      const double s = (at - p[across]) / (q[across] - p[across]);
      if (!(s >= 0 && s <= 1)) continue;
      const Vector3d on = p + s * (q - p);
      cut.emplace_back(static_cast<float>(on[a]), static_cast<float>(sign_b * on[b]));
    }
  if (cut.size() < 3) return {};
  std::vector<cv::Point2f> hull;
  cv::convexHull(cut, hull);
  std::vector<Vector2d> outline;
  for (const cv::Point2f& p : hull) outline.emplace_back(static_cast<double>(p.x), static_cast<double>(p.y));
  return outline;
}

const std::array kLevelColours{colours::kSkyBlue, colours::kGreen, colours::kOrange, colours::kVermilion,
                               colours::kPurple};

/// One section: depth to the right, `b` (sign turned) upwards.
cv::Mat section_plot(const vision::Characteristics& rig, const ResolutionScale& scale, int across, double at,
                     int b, double reach, double middle, const std::string& title, const std::string& label) {
  constexpr int kCells = 130, kWidth = 560;
  const double far = rig.rectified.farthest;
  // The same scale along both axes.
  const double height_share = 2 * reach / (1.04 * far);
  const int height = static_cast<int>(std::lround((kWidth - 84) * height_share)) + 88;
  Plot plot(kWidth, height, {0, 1.04 * far, "depth [m]"}, {middle - reach, middle + reach, label}, title);
  const double cell = 1.04 * far / kCells;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < static_cast<int>(2 * reach / cell) + 1; ++j) {
      Vector3d p;
      p[across] = at, p.z() = (i + 0.5) * cell, p[b] = -(middle - reach + (j + 0.5) * cell);
      if (!rig.field.contains(p)) continue;
      plot.cell({p.z() - cell / 2, -p[b] - cell / 2}, {p.z() + cell / 2, -p[b] + cell / 2},
                scale.colour(vision::resolution(rig.rectified, p)));
    }
  plot.outline(section(rig.field.corners, across, at, 2, b, -1), colours::kInk, 2);
  // The coarser first, so that the finer lie on them.
  for (std::size_t i = rig.resolved.size(); i-- > 0;) {
    const auto outline = section(rig.resolved[i].polytope.corners, across, at, 2, b, -1);
    if (outline.empty()) continue;
    plot.outline(outline, colours::kPaper, 4);
    plot.outline(outline, kLevelColours.at(i % kLevelColours.size()), 2);
    const auto highest = std::max_element(outline.begin(), outline.end(),
                                          [](const Vector2d& p, const Vector2d& q) { return p.y() < q.y(); });
    plot.note(*highest, fmt::format("{:g} mm", rig.resolved[i].resolution * 1e3), colours::kInk,
              Align::kRight, 7);
  }
  return plot.finished();
}

}  // namespace

cv::Mat sections_picture(const vision::Characteristics& rig) {
  const ResolutionScale scale(rig);
  double x = 0, low = 0, high = 0;
  for (const Vector3d& corner : rig.field.corners) {
    x = std::max(x, std::abs(corner.x() - rig.rectified.baseline / 2));
    low = std::min(low, -corner.y()), high = std::max(high, -corner.y());
  }
  const double reach = 1.12 * std::max(x, (high - low) / 2);
  const cv::Mat plan =
      section_plot(rig, scale, 1, 0, 0, reach, -rig.rectified.baseline / 2, "from above", "left [m]");
  const cv::Mat side = section_plot(rig, scale, 0, rig.rectified.baseline / 2, 1, reach, (low + high) / 2,
                                    "from the side", "up [m]");
  return scale.beside({plan, side});
}

cv::Mat resolution_plot(const vision::Characteristics& rig) {
  std::vector<Vector2d> axis, worst, measured;
  double highest = 0, lowest = std::numeric_limits<double>::infinity();
  for (const vision::SightAt& s : rig.sights) {
    axis.emplace_back(s.depth, s.on_axis * 1e3);
    worst.emplace_back(s.depth, std::max(s.on_axis, s.worst) * 1e3);
    measured.emplace_back(s.depth, s.measured * 1e3);
    highest = std::max(highest, worst.back().y()), lowest = std::min(lowest, axis.back().y());
  }
  Plot plot(640, 440, {rig.sights.front().depth * 0.93, rig.sights.back().depth * 1.07, "depth [m]", true},
            {0.7 * lowest, 1.5 * highest, "[mm]", true},
            "resolution: the largest standard deviation of a point");
  plot.band(axis, worst, mixed(colours::kSkyBlue, colours::kPaper, 0.55),
            "from the axis to the worst corner");
  plot.line(axis, colours::kBlue, "formula, on the axis");
  plot.dots(measured, colours::kVermilion, "measured: 2000 triangulations each");
  return plot.finished();
}

cv::Mat angles_plot(const vision::RectifiedRig& rig) {
  std::vector<Vector2d> horizontal, vertical;
  const double nearest = 0.3 * rig.nearest, farthest = 3 * rig.farthest;
  double highest = kPaperField;
  for (int i = 0; i <= 200; ++i) {
    const double z = nearest * std::pow(farthest / nearest, i / 200.0);
    const vision::FieldAngles angles = vision::field_angles(rig, z);
    if (angles.horizontal <= 0) continue;
    horizontal.emplace_back(z, angles.horizontal / kDegree);
    vertical.emplace_back(z, angles.vertical / kDegree);
    highest = std::max({highest, horizontal.back().y(), vertical.back().y()});
  }
  Plot plot(640, 440, {nearest, farthest, "depth [m]", true}, {0, 1.45 * highest, "[deg]"},
            "field of view that both cameras share");
  plot.line({{nearest, kPaperField}, {farthest, kPaperField}}, colours::kOrange,
            "the paper's 33 deg, both ways");
  plot.line(vertical, colours::kGreen, "up and down");
  plot.line(horizontal, colours::kBlue, "left to right");
  return plot.finished();
}

}  // namespace headway::app
