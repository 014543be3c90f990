#include "app/map_figures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace headway::app {

namespace {

constexpr double kMarksPerMetre = 100;  // pixels of the floor marks
constexpr double kWidestMarks = 60;     // [m]

// Blue, green, red.
const Colour kMetal{176, 168, 160}, kBlue{180, 110, 50}, kDark{70, 62, 58}, kEye{60, 200, 240},
    kRed{50, 50, 220};

Eigen::AlignedBox3d box(double x, double y, double z, double depth, double width, double height) {
  const Eigen::Vector3d half(depth / 2, width / 2, height / 2), middle(x, y, z + height / 2);
  return {middle - half, middle + half};
}

struct BoxHit {
  double t;
  int axis, side;
};

std::optional<BoxHit> meet_box(const Eigen::AlignedBox3d& extent, const Eigen::Vector3d& eye,
                               const Eigen::Vector3d& direction) {
  double t_in = 0, t_out = std::numeric_limits<double>::infinity();
  int axis = -1;
  for (int a = 0; a < 3; ++a) {
    const double low = extent.min()[a] - eye[a], high = extent.max()[a] - eye[a];
    if (std::abs(direction[a]) < 1e-12) {
      if (low > 0 || high < 0) return std::nullopt;
      continue;
    }
    const double t_low = low / direction[a], t_high = high / direction[a];
    if (std::min(t_low, t_high) > t_in) t_in = std::min(t_low, t_high), axis = a;
    t_out = std::min(t_out, std::max(t_low, t_high));
  }
  if (axis < 0 || t_in > t_out) return std::nullopt;
  return BoxHit{t_in, axis, direction[axis] > 0 ? -1 : 1};
}

double brightness(const BoxHit& hit) {
  if (hit.axis == 2) return hit.side > 0 ? 1.15 : 0.5;
  return (hit.axis == 0 ? 0.95 : 0.75) - (hit.side < 0 ? 0.08 : 0);
}

Colour lit(const Colour& c, double share) {
  return share < 1 ? mixed({0, 0, 0}, c, share) : mixed(c, {255, 255, 255}, std::min(1.0, share - 1));
}

}  // namespace

FigureBoxes::FigureBoxes(const MapFigures& figures, double floor_height) {
  if (figures.robot) {
    add(figures.robot->lifted(floor_height), {{box(0.02, 0.095, 0.00, 0.22, 0.13, 0.08), kDark},
                                              {box(0.02, -0.095, 0.00, 0.22, 0.13, 0.08), kDark},
                                              {box(0.00, 0.095, 0.08, 0.13, 0.12, 0.62), kMetal},
                                              {box(0.00, -0.095, 0.08, 0.13, 0.12, 0.62), kMetal},
                                              {box(0.00, 0.00, 0.70, 0.20, 0.30, 0.16), kBlue},
                                              {box(0.00, 0.00, 0.86, 0.24, 0.36, 0.46), kMetal},
                                              {box(0.00, 0.25, 0.72, 0.11, 0.11, 0.58), kBlue},
                                              {box(0.00, -0.25, 0.72, 0.11, 0.11, 0.58), kBlue},
                                              {box(0.01, 0.00, 1.34, 0.20, 0.18, 0.24), kBlue},
                                              {box(0.11, 0.00, 1.44, 0.03, 0.15, 0.06), kEye}});
  }
  if (figures.goal) {
    add(Pose2{figures.goal->x(), figures.goal->y(), 0}.lifted(floor_height),
        {{box(0, 0, 0, 0.03, 0.03, 0.9), kDark}, {box(0.13, 0, 0.7, 0.26, 0.02, 0.2), kRed}});
  }
}

void FigureBoxes::add(const Eigen::Isometry3d& map_from_group, std::vector<Box> boxes) {
  Eigen::AlignedBox3d extent;
  for (const Box& b : boxes) extent.extend(b.extent);
  groups_.push_back({map_from_group.inverse(), extent, std::move(boxes)});
}

std::optional<FigureHit> FigureBoxes::meet(const Eigen::Vector3d& eye,
                                           const Eigen::Vector3d& direction) const {
  std::optional<FigureHit> nearest;
  for (const Group& group : groups_) {
    const Eigen::Vector3d from = group.group_from_map * eye,
                          along = group.group_from_map.linear() * direction;
    if (!group.extent.contains(from) && !meet_box(group.extent, from, along)) continue;
    for (const Box& b : group.boxes) {
      const auto hit = meet_box(b.extent, from, along);
      if (!hit || (nearest && nearest->t <= hit->t)) continue;
      nearest = FigureHit{hit->t, lit(b.colour, brightness(*hit))};
    }
  }
  return nearest;
}

FloorMarks::FloorMarks(const MapFigures& figures) {
  Eigen::AlignedBox2d extent;
  for (const Eigen::Vector2d& p : figures.path) {
    if (p.allFinite()) extent.extend(p);
  }
  for (const FootPrint& foot : figures.feet) {
    if (foot.pose.position().allFinite()) extent.extend(foot.pose.position());
  }
  if (extent.isEmpty() || extent.sizes().maxCoeff() > kWidestMarks) return;
  lowest_ = extent.min() - Eigen::Vector2d::Constant(0.3);
  const Eigen::Vector2i size = ((extent.sizes().array() + 0.6) * kMarksPerMetre).ceil().cast<int>();
  colours_.create(size.y(), size.x());
  drawn_ = cv::Mat1b::zeros(size.y(), size.x());
  const auto pixel = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d at = (p - lowest_) * kMarksPerMetre;
    return cv::Point(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
  };
  const auto fill = [&](const std::vector<cv::Point>& corners, const Colour& colour) {
    cv::fillPoly(colours_, std::vector{corners}, scalar(colour));
    cv::fillPoly(drawn_, std::vector{corners}, cv::Scalar(255));
  };
  for (std::size_t i = 0; i + 1 < figures.path.size(); ++i) {
    const cv::Point a = pixel(figures.path[i]), b = pixel(figures.path[i + 1]);
    cv::line(colours_, a, b, scalar(colours::kPath), 4);
    cv::line(drawn_, a, b, cv::Scalar(255), 4);
  }
  for (const FootPrint& foot : figures.feet) {
    const double x = figures.gait.sole_length / 2, y = figures.gait.sole_width / 2;
    const Colour& colour = foot.foot == hal::Foot::kLeft ? colours::kLeftFoot : colours::kRightFoot;
    fill({pixel(foot.pose * Eigen::Vector2d(x, y)), pixel(foot.pose * Eigen::Vector2d(-x, y)),
          pixel(foot.pose * Eigen::Vector2d(-x, -y)), pixel(foot.pose * Eigen::Vector2d(x, -y))},
         foot.committed ? colour : mixed(colour, {255, 255, 255}, 0.45));
  }
}

std::optional<Colour> FloorMarks::at(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d at = (point - lowest_) * kMarksPerMetre;
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < drawn_.cols && at.y() < drawn_.rows)) return std::nullopt;
  const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
  if (drawn_(y, x) == 0) return std::nullopt;
  return colours_(y, x);
}

}  // namespace headway::app
