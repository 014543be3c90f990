#include "app/rig_pictures.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "app/plot.h"
#include "app/scene_picture.h"
#include "vision/hull.h"

namespace headway::app {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kPaperField = 33;  // [deg], each way

/// From the optical frame to x forward, y left, z up.
Vector3d turned(const Vector3d& p) { return {p.z(), -p.x(), -p.y()}; }

/// Colours of resolutions on a logarithmic scale; the ramp's brightest end is left out, it fades on paper.
class Scale {
 public:
  Scale(double lowest, double highest) : lowest_(lowest), highest_(std::max(highest, 1.01 * lowest)) {}
  Colour colour(double resolution) const {
    return ramp_colour(Ramp::kInferno, kTop * std::log(resolution / lowest_) / std::log(highest_ / lowest_));
  }
  /// A bar with its marks, into a column of white of that height.
  cv::Mat bar(int height) const {
    constexpr int kWidth = 118, kMargin = 40;
    cv::Mat out = canvas(kWidth, height, colours::kPaper);
    const cv::Rect bar(14, kMargin, 18, height - 2 * kMargin);
    for (int y = 0; y < bar.height; ++y)
      out(cv::Rect(bar.x, bar.y + y, bar.width, 1)) =
          ramp_colour(Ramp::kInferno, kTop * (1 - y / (bar.height - 1.0)));
    for (const Tick& tick : logarithmic_length_ticks(lowest_, highest_)) {
      const int y = bar.y + static_cast<int>(std::lround((1 - tick.share) * (bar.height - 1)));
      out(cv::Rect(bar.x + bar.width, y, 4, 1)) = colours::kInk;
      draw_text(out, tick.label, {bar.x + bar.width + 8, y + 4}, colours::kInk, 9);
    }
    draw_text(out, "resolution", {bar.x, kMargin - 14}, colours::kInk, 9);
    return out;
  }

 private:
  static constexpr double kTop = 0.86;
  double lowest_, highest_;
};

double resolution_of(const vision::UncertainPoint& point) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(point.covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(solver.eigenvalues()(2), 1e-18));
}

Scale scale_of(const vision::Characteristics& rig) {
  double lowest = std::numeric_limits<double>::infinity(), highest = 0;
  for (const vision::SightAt& s : rig.sights) {
    lowest = std::min(lowest, s.on_axis);
    highest = std::max({highest, s.on_axis, s.worst});
  }
  return {lowest, highest};
}

void draw_camera(ScenePicture& scene, const vision::PinholeCamera& camera, const Vector3d& at, double size) {
  std::vector<Vector3d> corners;
  for (const double v : {-0.5, camera.height - 0.5})
    for (const double u : {-0.5, camera.width - 0.5})
      corners.push_back(turned(at + camera.point(u, v, size)));
  for (const Vector3d& corner : corners) scene.line(turned(at), corner, colours::kBlue, 1.5, 1);
  for (const auto& [i, j] : {std::pair{0U, 1U}, {1U, 3U}, {3U, 2U}, {2U, 0U}})
    scene.line(corners[i], corners[j], colours::kBlue, 1.5, 1);
}

/// Squares of whole metres (or more) on the ground below the field.
struct Ground {
  double step, z, y0, y1, x1;

  explicit Ground(const Eigen::AlignedBox3d& box) : step(tick_step(box.max().x(), 6)), z(box.min().z()) {
    y0 = std::floor(box.min().y() / step) * step, y1 = std::ceil(box.max().y() / step) * step;
    x1 = std::ceil(box.max().x() / step - 1e-9) * step;
  }
  std::vector<Vector3d> corners() const {
    return {{-0.4 * step, y0 - 0.3 * step, z}, {0, y1, z}, {x1, y0 - 0.3 * step, z}, {x1, y1, z}};
  }
  void draw(ScenePicture& scene) const {
    const Colour line{214, 210, 206};
    for (double x = 0; x < x1 + step / 2; x += step) scene.line({x, y0, z}, {x, y1, z}, line, 1, 1);
    for (double y = y0; y < y1 + step / 2; y += step) scene.line({0, y, z}, {x1, y, z}, line, 1, 1);
  }
  void label(const ScenePicture& scene, cv::Mat& image) const {
    for (double x = 0; x < x1 + step / 2; x += step)
      if (const auto at = scene.pixel({x, y0 - 0.25 * step, z}))
        draw_text(image, fmt::format("{:g} m", x), *at, colours::kInk, 9, Align::kCentre);
  }
};

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
cv::Mat section_plot(const vision::Characteristics& rig, const Scale& scale, int across, double at, int b,
                     double reach, double middle, const std::string& title, const std::string& label) {
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

cv::Mat beside(const std::vector<cv::Mat>& pictures) {
  int height = 0;
  for (const cv::Mat& p : pictures) height = std::max(height, p.rows);
  std::vector<cv::Mat> padded;
  for (const cv::Mat& p : pictures) {
    const int above = (height - p.rows) / 2;
    const Colour paper = colours::kPaper;
    padded.emplace_back();
    cv::copyMakeBorder(p, padded.back(), above, height - p.rows - above, 0, 0, cv::BORDER_CONSTANT,
                       cv::Scalar(paper[0], paper[1], paper[2]));
  }
  cv::Mat out;
  cv::hconcat(padded, out);
  return out;
}

/// Where a direction of the head's camera lies on a chart: to the right and up [deg].
Vector2d on_chart(const Vector3d& direction) {
  const Vector3d d = direction.normalized();
  return {-std::atan2(d.y(), d.x()) / kDegree, std::asin(d.z()) / kDegree};
}

Vector2d gaze(const hal::HeadKinematics& neck, const hal::HeadAngles& view) {
  return on_chart(neck.chest_from_camera(view).linear().col(2));
}

/// The directions that the camera's axis can point at: along the joints' limits.
std::vector<Vector2d> gaze_outline(const hal::HeadKinematics& neck, const hal::HeadLimits& limits) {
  constexpr int kSteps = 12;
  const hal::HeadAngles a = limits.lower, b = limits.upper;
  const std::array<hal::HeadAngles, 4> corners{a, {b.pan, a.tilt}, b, {a.pan, b.tilt}};
  std::vector<Vector2d> outline;
  for (std::size_t i = 0; i < 4; ++i)
    for (int k = 0; k < kSteps; ++k) {
      const hal::HeadAngles &from = corners[i], &to = corners[(i + 1) % 4];
      const double share = static_cast<double>(k) / kSteps;
      outline.push_back(
          gaze(neck, {std::lerp(from.pan, to.pan, share), std::lerp(from.tilt, to.tilt, share)}));
    }
  return outline;
}

cv::Mat tour_plot(const vision::Polytope& field, const hal::HeadKinematics& neck,
                  const hal::HeadLimits& limits, const Tour& tour) {
  constexpr double kCell = 1.5;
  const Colour once = mixed(colours::kSkyBlue, colours::kPaper, 0.35),
               missed = mixed(colours::kOrange, colours::kPaper, 0.2);
  const std::vector<vision::Polytope> shown = vision::fields_of(field, neck, tour.views),
                                      any = vision::fields_of(field, neck, vision::all_directions(limits));
  const Vector3d centre = (neck.chest_from_pan * neck.pan_from_tilt).translation();
  Plot plot(480, 460, {-90, 90, "to the right [deg]"}, {-90, 90, "up [deg]"}, "");
  for (double up = -90; up < 90; up += kCell)
    for (double right = -90; right < 90; right += kCell) {
      const double e = (up + kCell / 2) * kDegree, r = (right + kCell / 2) * kDegree;
      const Vector3d point = centre + tour.distance * Vector3d(std::cos(e) * std::cos(r),
                                                               -std::cos(e) * std::sin(r), std::sin(e));
      const auto holds = [&](const vision::Polytope& p) { return p.contains(point); };
      const auto count = std::count_if(shown.begin(), shown.end(), holds);
      if (count == 0 && std::none_of(any.begin(), any.end(), holds)) continue;
      const Colour colour =
          count == 0 ? missed
                     : mixed(once, colours::kBlue, std::min(1.0, 0.3 * static_cast<double>(count - 1)));
      plot.cell({right, up}, {right + kCell, up + kCell}, colour);
    }
  plot.outline(gaze_outline(neck, limits), colours::kInk, 1);
  std::vector<Vector2d> at;
  for (const hal::HeadAngles& view : tour.views) at.push_back(gaze(neck, view));
  plot.dots(at, colours::kInk, "");
  for (std::size_t i = 0; i < at.size(); ++i)
    plot.note(at[i], std::to_string(i + 1), colours::kInk, Align::kCentre, 8);
  plot.key({once, "shown (darker: by several views)", Key::Shape::kPatch});
  plot.key({missed, "the head could show it", Key::Shape::kPatch});
  plot.key({colours::kInk, "where the axis can point", Key::Shape::kFrame});
  return plot.finished();
}

}  // namespace

std::vector<ColouredPoint> coloured_points(const vision::Characteristics& rig) {
  const Scale scale = scale_of(rig);
  std::vector<ColouredPoint> points;
  for (const vision::UncertainPoint& p : rig.pairs.points)
    points.push_back({p.position, scale.colour(resolution_of(p))});
  return points;
}

cv::Mat field_picture(const vision::Characteristics& rig) {
  constexpr int kWidth = 860, kHeight = 560;
  Eigen::AlignedBox3d box(Vector3d::Zero());
  for (const Vector3d& corner : rig.field.corners) box.extend(turned(corner));
  const Ground ground(box);
  std::vector<Vector3d> all = ground.corners();
  for (const Vector3d& corner : rig.field.corners) all.push_back(turned(corner));
  ScenePicture scene(framing(all, -0.38 * std::numbers::pi, 0.2, kWidth, kHeight), kWidth, kHeight);
  ground.draw(scene);
  for (const ColouredPoint& p : coloured_points(rig)) scene.dot(turned(p.position), 1.3, p.colour);
  for (const auto& [i, j] : vision::edges(rig.field))
    scene.line(turned(rig.field.corners[i]), turned(rig.field.corners[j]), colours::kInk, 1.6, 0.55);
  vision::PinholeCamera right = rig.rectified.camera;
  right.cx += rig.rectified.disparity_offset;
  draw_camera(scene, rig.rectified.camera, Vector3d::Zero(), 0.05 * rig.rectified.farthest);
  draw_camera(scene, right, Vector3d(rig.rectified.baseline, 0, 0), 0.05 * rig.rectified.farthest);
  cv::Mat image = scene.finished();
  ground.label(scene, image);
  draw_text(image,
            fmt::format("{} points from pixel pairs, and the field A x >= 0 of {} half-spaces",
                        rig.pairs.points.size(), rig.field.rows.size()),
            {14, 24}, colours::kInk, 11);
  return beside({image, scale_of(rig).bar(kHeight)});
}

cv::Mat sections_picture(const vision::Characteristics& rig) {
  const Scale scale = scale_of(rig);
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
  return beside({plan, side, scale.bar(plan.rows)});
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

cv::Mat fields_picture(const std::vector<NamedField>& fields) {
  constexpr int kWidth = 860, kHeight = 560;
  Eigen::AlignedBox3d box(Vector3d::Zero());
  std::vector<Vector3d> all;
  for (const NamedField& f : fields)
    for (const Vector3d& corner : f.field.corners) box.extend(corner), all.push_back(corner);
  const Ground ground(box);
  for (const Vector3d& corner : ground.corners()) all.push_back(corner);
  ScenePicture scene(framing(all, -0.38 * std::numbers::pi, 0.2, kWidth, kHeight), kWidth, kHeight);
  ground.draw(scene);
  std::vector<Key> keys;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const vision::Polytope& field = fields[i].field;
    // Light colours are hard to see as lines: the dark ones come first.
    const Colour colour = std::array{colours::kBlue,   colours::kVermilion, colours::kGreen,
                                     colours::kPurple, colours::kOrange,    colours::kSkyBlue}
                              .at(i % 6);
    for (const auto& [a, b] : vision::edges(field))
      scene.line(field.corners[a], field.corners[b], colour, 2, 0.6);
    for (const Vector3d& camera : fields[i].cameras) scene.dot(camera, 2.5, colour);
    keys.push_back({colour, fields[i].name, Key::Shape::kLine});
  }
  cv::Mat image = scene.finished();
  ground.label(scene, image);
  draw_keys(image, {14, 10}, keys, colours::kInk);
  return image;
}

cv::Mat tours_picture(const vision::Polytope& field, const hal::HeadKinematics& neck,
                      const hal::HeadLimits& limits, const std::vector<Tour>& tours) {
  std::vector<Captioned> plots;
  for (const Tour& tour : tours) plots.push_back({tour_plot(field, neck, limits, tour), tour.caption});
  return strip(plots);
}

}  // namespace headway::app
