#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "app/pictures.h"
#include "nav/low_ahead.h"

namespace headway::app {

namespace {

constexpr int kLeft = 58, kTop = 36, kBottom = 48, kRight = 190;  // room around the plan [px]
constexpr int kShift = 4;                                         // fractional bits of pixel positions
constexpr double kFarthestOff = 2;  // how far beyond the map the picture may reach [m]

// Blue, green, red.
const Colour kFree{250, 250, 250}, kUnseen{196, 190, 184}, kBlocked{72, 62, 56}, kOutside{222, 218, 214};
const Colour kBody{200, 160, 60}, kTrail{150, 30, 130}, kBelieved{210, 130, 220}, kTruth{60, 60, 200},
    kFormerPath{190, 170, 120}, kCollision{20, 20, 230};
const Colour kStart{110, 110, 110}, kGoal{40, 40, 220}, kRobot{160, 90, 10};

using Line = std::vector<Eigen::Vector2d>;

/// The corners of a rectangle around a pose.
Line rectangle(const Pose2& at, double half_depth, double half_width) {
  return {at * Eigen::Vector2d(half_depth, half_width), at * Eigen::Vector2d(-half_depth, half_width),
          at * Eigen::Vector2d(-half_depth, -half_width), at * Eigen::Vector2d(half_depth, -half_width)};
}

/// The rectangle grown by the clearance, with round corners.
Line grown_outline(const nav::BodyOutline& body, const Pose2& base) {
  constexpr int kArc = 4;  // points per corner, less one
  Line line;
  for (int corner = 0; corner < 4; ++corner) {
    const double sx = corner == 0 || corner == 3 ? 1 : -1, sy = corner < 2 ? 1 : -1;
    for (int i = 0; i <= kArc; ++i) {
      const double angle = (corner + static_cast<double>(i) / kArc) * std::numbers::pi / 2;
      line.push_back(base * Eigen::Vector2d(sx * body.half_depth + body.clearance() * std::cos(angle),
                                            sy * body.half_width + body.clearance() * std::sin(angle)));
    }
  }
  return line;
}

/// The part of the plane that the picture shows, in cells of the grid (may reach beyond it).
struct Frame {
  Eigen::Vector2i first, last;  ///< cells, both inclusive

  void include(const Eigen::Vector2i& cell) {
    first = first.cwiseMin(cell);
    last = last.cwiseMax(cell);
  }
};

void include_layers(const FloorLayers& layers, const nav::FloorGrid& grid, Frame& frame) {
  const Eigen::Vector2d lowest = grid.origin,
                        highest = grid.origin + grid.resolution * Eigen::Vector2d(grid.width, grid.height);
  const auto include = [&](const Eigen::Vector2d& p) {
    if (!p.allFinite()) return;
    // A point far off the map must not make the picture huge.
    frame.include(grid.cell(p.cwiseMax(lowest - Eigen::Vector2d::Constant(kFarthestOff))
                                .cwiseMin(highest + Eigen::Vector2d::Constant(kFarthestOff))));
  };
  for (const Line* line :
       {&layers.path, &layers.former_path, &layers.trail, &layers.believed_trail, &layers.collisions}) {
    std::for_each(line->begin(), line->end(), include);
  }
  for (const Line& line : layers.obstacles) std::for_each(line.begin(), line.end(), include);
  for (const FootPrint& foot : layers.feet) include(foot.pose.position());
  for (const Pose2& base : layers.bodies) include(base.position());
  if (layers.start) include(layers.start->position());
  if (layers.robot) include(layers.robot->position());
  if (layers.goal) include(*layers.goal);
}

Frame frame_of(const nav::FloorMap& floor, const FloorLayers& layers, bool crop) {
  const nav::FloorGrid& grid = floor.grid;
  const Frame whole{{0, 0}, {std::max(0, grid.width - 1), std::max(0, grid.height - 1)}};
  if (!crop) return whole;
  Frame frame{whole.last, whole.first};
  bool any = false;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (floor.at({x, y}) == nav::Floor::kUnseen) continue;
      frame.include({x, y});
      any = true;
    }
  }
  include_layers(layers, grid, frame);
  if (!any && frame.first == whole.last && frame.last == whole.first) return whole;
  const int margin = static_cast<int>(std::ceil(0.4 / grid.resolution));
  frame.first.array() -= margin;
  frame.last.array() += margin;
  return frame;
}

/// Places metres on the picture, and draws there.
class Plan {
 public:
  Plan(const nav::FloorGrid& grid, const Frame& frame, int least_px)
      : cells_(frame.last - frame.first + Eigen::Vector2i::Ones()),
        px_per_cell_(std::clamp((least_px + cells_.maxCoeff() - 1) / cells_.maxCoeff(), 1, 60)),
        px_per_metre_(px_per_cell_ / grid.resolution),
        lowest_(grid.origin + grid.resolution * frame.first.cast<double>()),
        image_(canvas(kLeft + cells_.x() * px_per_cell_ + kRight, kTop + cells_.y() * px_per_cell_ + kBottom,
                      colours::kPaper)) {}

  cv::Mat& image() { return image_; }
  const Eigen::Vector2i& cells() const { return cells_; }
  double px_per_metre() const { return px_per_metre_; }
  cv::Rect area() const { return {kLeft, kTop, cells_.x() * px_per_cell_, cells_.y() * px_per_cell_}; }
  /// The cell that is (x, y) cells from the lower left of the frame.
  cv::Rect cell(int x, int y) const {
    return {kLeft + x * px_per_cell_, kTop + (cells_.y() - 1 - y) * px_per_cell_, px_per_cell_, px_per_cell_};
  }
  Eigen::Vector2d lowest() const { return lowest_; }
  Eigen::Vector2d highest() const { return lowest_ + cells_.cast<double>() * px_per_cell_ / px_per_metre_; }

  Eigen::Vector2d pixel(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d in_frame = (p - lowest_) * px_per_metre_;
    return {kLeft + in_frame.x(), kTop + cells_.y() * px_per_cell_ - in_frame.y()};
  }
  cv::Point whole_pixel(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d at = pixel(p);
    return {static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y()))};
  }

  void line(const Line& points, bool closed, const Colour& colour, int width) {
    cv::polylines(image_, std::vector{fixed(points)}, closed, scalar(colour), width, cv::LINE_AA, kShift);
  }
  void fill(const Line& points, const Colour& colour) { fill(image_, points, scalar(colour)); }
  void fill(cv::Mat& image, const Line& points, const cv::Scalar& value) const {
    cv::fillPoly(image, std::vector{fixed(points)}, value, cv::LINE_8, kShift);
  }
  void dot(const Eigen::Vector2d& p, int radius, const Colour& colour) {
    cv::circle(image_, whole_pixel(p), radius, scalar(colour), cv::FILLED, cv::LINE_AA);
  }
  void ring(const Eigen::Vector2d& p, int radius, const Colour& colour) {
    cv::circle(image_, whole_pixel(p), radius, scalar(colour), 3, cv::LINE_AA);
  }
  void arrow(const Pose2& from, double length, const Colour& colour) {
    const Eigen::Vector2d tip = from.position() + length * from.heading();
    cv::arrowedLine(image_, whole_pixel(from.position()), whole_pixel(tip), scalar(colour), 3, cv::LINE_AA, 0,
                    0.35);
  }
  void cross(const Eigen::Vector2d& p, int radius, const Colour& colour) {
    const cv::Point at = whole_pixel(p);
    cv::drawMarker(image_, at, scalar(colour), cv::MARKER_TILTED_CROSS, 2 * radius, 4, cv::LINE_AA);
  }

 private:
  std::vector<cv::Point> fixed(const Line& points) const {
    std::vector<cv::Point> out;
    for (const Eigen::Vector2d& p : points) {
      // Far outside the picture is as good as farther outside, and stays an int.
      const Eigen::Vector2d at = pixel(p).cwiseMax(-30000).cwiseMin(30000) * (1 << kShift);
      out.emplace_back(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
    }
    return out;
  }

  Eigen::Vector2i cells_;
  int px_per_cell_;
  double px_per_metre_;
  Eigen::Vector2d lowest_;
  cv::Mat image_;
};

void draw_cells(const nav::FloorMap& floor, const Frame& frame, Plan& plan) {
  for (int y = 0; y < plan.cells().y(); ++y) {
    for (int x = 0; x < plan.cells().x(); ++x) {
      const Eigen::Vector2i cell = frame.first + Eigen::Vector2i(x, y);
      const nav::Floor state = floor.at(cell);
      const Colour& known = state == nav::Floor::kFree      ? kFree
                            : state == nav::Floor::kBlocked ? kBlocked
                            : state == nav::Floor::kLow     ? colours::kLow
                                                            : kUnseen;
      plan.image()(plan.cell(x, y)).setTo(scalar(floor.grid.contains(cell) ? known : kOutside));
    }
  }
}

void draw_axis(Plan& plan, int axis) {
  const double lowest = plan.lowest()[axis], highest = plan.highest()[axis];
  const double step = tick_step(highest - lowest, 8);
  const cv::Rect area = plan.area();
  for (int i = static_cast<int>(std::ceil(lowest / step)); i * step <= highest; ++i) {
    Eigen::Vector2d at = plan.lowest();
    at[axis] = i * step;
    const cv::Point p = plan.whole_pixel(at);
    const std::string label = fmt::format("{:g}", std::round(i * step * 1e6) / 1e6);
    const Colour grid = mixed(kUnseen, colours::kInk, 0.12);
    if (axis == 0) {
      cv::line(plan.image(), {p.x, area.y}, {p.x, area.y + area.height}, scalar(grid));
      draw_text(plan.image(), label, {p.x, area.y + area.height + 18}, colours::kInk, 10, Align::kCentre);
    } else {
      cv::line(plan.image(), {area.x, p.y}, {area.x + area.width, p.y}, scalar(grid));
      draw_text(plan.image(), label, {area.x - 8, p.y + 5}, colours::kInk, 10, Align::kRight);
    }
  }
}

void draw_axes(Plan& plan, const std::string& title) {
  draw_axis(plan, 0);
  draw_axis(plan, 1);
  const cv::Rect area = plan.area();
  cv::rectangle(plan.image(), area, scalar(colours::kInk));
  draw_text(plan.image(), "x [m]", {area.x + area.width / 2, area.y + area.height + 39}, colours::kInk, 10,
            Align::kCentre);
  draw_text(plan.image(), "y [m]", {8, area.y - 10}, colours::kInk, 10);
  draw_text(plan.image(), title, {area.x + area.width / 2, 24}, colours::kInk, 13, Align::kCentre);
}

/// All masks as one veil, so that where many overlap one still sees the floor, and the outline of each.
void draw_bodies(const FloorLayers& layers, Plan& plan) {
  cv::Mat touched = cv::Mat::zeros(plan.image().size(), CV_8U);
  for (const Pose2& base : layers.bodies) plan.fill(touched, grown_outline(layers.outline, base), 255);
  cv::Mat veil(plan.image().size(), CV_8UC3, scalar(kBody));
  cv::addWeighted(veil, 0.22, plan.image(), 0.78, 0, veil);
  veil.copyTo(plan.image(), touched);
  for (const Pose2& base : layers.bodies) {
    plan.line(grown_outline(layers.outline, base), true, mixed(kBody, kFree, 0.35), 1);
  }
}

void draw_feet(const FloorLayers& layers, Plan& plan) {
  for (const FootPrint& foot : layers.feet) {
    const Colour& colour = foot.foot == hal::Foot::kLeft ? colours::kLeftFoot : colours::kRightFoot;
    const Line sole = rectangle(foot.pose, layers.gait.sole_length / 2, layers.gait.sole_width / 2);
    plan.fill(sole, foot.committed ? colour : mixed(colour, kFree, 0.75));
    plan.line(sole, true, colour, 1);
  }
}

void draw_marks(const FloorLayers& layers, Plan& plan) {
  if (layers.start) {
    plan.ring(layers.start->position(), 9, kStart);
    plan.arrow(*layers.start, 0.3, kStart);
  }
  if (layers.goal) {
    plan.ring(*layers.goal, 13, kGoal);
    plan.dot(*layers.goal, 5, kGoal);
    if (layers.goal_yaw) plan.arrow({layers.goal->x(), layers.goal->y(), *layers.goal_yaw}, 0.35, kGoal);
  }
  if (layers.robot) {
    plan.line(rectangle(*layers.robot, layers.outline.half_depth, layers.outline.half_width), true, kRobot,
              3);
    plan.arrow(*layers.robot, 0.35, kRobot);
  }
  for (const Eigen::Vector2d& p : layers.collisions) plan.cross(p, 12, kCollision);
}

std::vector<Key> keys_of(const FloorLayers& layers, bool any_low, bool beyond_the_map) {
  using Shape = Key::Shape;
  std::vector<Key> keys{{kFree, "free"}, {kBlocked, "blocked"}, {kUnseen, "unseen"}};
  const auto add = [&](bool drawn, const Colour& colour, const std::string& label, Shape shape) {
    if (drawn) keys.push_back({colour, label, shape});
  };
  add(any_low, colours::kLow, "low, stepped over", Shape::kPatch);
  add(beyond_the_map, kOutside, "outside the map", Shape::kPatch);
  const auto foot = [&](hal::Foot side, bool committed) {
    return std::any_of(layers.feet.begin(), layers.feet.end(),
                       [&](const FootPrint& f) { return f.foot == side && f.committed == committed; });
  };
  add(layers.start.has_value(), kStart, "start", Shape::kDot);
  add(layers.goal.has_value(), kGoal, layers.goal_label, Shape::kDot);
  add(layers.robot.has_value(), kRobot, "robot", Shape::kFrame);
  add(!layers.former_path.empty(), kFormerPath, "path before", Shape::kLine);
  add(!layers.path.empty(), colours::kPath, "path", Shape::kLine);
  add(!layers.waist.empty(), colours::kPurple, "waist", Shape::kLine);
  add(!layers.zmp.empty(), colours::kInk, "ZMP", Shape::kLine);
  add(!layers.bodies.empty(), mixed(kFree, kBody, 0.4), "body mask", Shape::kPatch);
  add(foot(hal::Foot::kLeft, true), colours::kLeftFoot, "left, committed", Shape::kPatch);
  add(foot(hal::Foot::kRight, true), colours::kRightFoot, "right, committed", Shape::kPatch);
  add(foot(hal::Foot::kLeft, false), mixed(colours::kLeftFoot, kFree, 0.75), "left, planned", Shape::kPatch);
  add(foot(hal::Foot::kRight, false), mixed(colours::kRightFoot, kFree, 0.75), "right, planned",
      Shape::kPatch);
  const bool told_apart = !layers.believed_trail.empty();
  add(!layers.trail.empty(), kTrail, told_apart ? "base, in truth" : "way", Shape::kLine);
  add(told_apart, kBelieved, "chest, odometry", Shape::kLine);
  add(!layers.obstacles.empty(), kTruth, "true obstacles", Shape::kFrame);
  add(!layers.collisions.empty(), kCollision, "collision", Shape::kDot);
  return keys;
}

}  // namespace

cv::Mat floor_picture(const nav::FloorMap& floor, const FloorLayers& layers,
                      const FloorPictureConfig& config) {
  const Frame frame = frame_of(floor, layers, config.crop);
  Plan plan(floor.grid, frame, config.least_px);
  draw_cells(floor, frame, plan);
  draw_axes(plan, config.title);
  if (!layers.bodies.empty()) draw_bodies(layers, plan);
  for (const Line& line : layers.obstacles) plan.line(line, true, kTruth, 2);
  plan.line(layers.former_path, false, kFormerPath, 3);
  plan.line(layers.path, false, colours::kPath, 3);
  draw_feet(layers, plan);
  plan.line(layers.waist, false, colours::kPurple, 2);
  plan.line(layers.zmp, false, colours::kInk, 1);
  plan.line(layers.believed_trail, false, kBelieved, 5);  // shows on both sides where the two agree
  plan.line(layers.trail, false, kTrail, 2);
  draw_marks(layers, plan);
  const cv::Rect area = plan.area();
  const bool beyond = !floor.grid.contains(frame.first) || !floor.grid.contains(frame.last);
  draw_keys(plan.image(), {area.x + area.width + 16, area.y}, keys_of(layers, nav::any_low(floor), beyond),
            colours::kInk);
  return plan.image();
}

}  // namespace headway::app
