#include "app/tour_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/plot.h"
#include "hal/angle.h"
#include "vision/viewpoints.h"

namespace headway::app {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

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

cv::Mat tours_picture(const vision::Polytope& field, const hal::HeadKinematics& neck,
                      const hal::HeadLimits& limits, const std::vector<Tour>& tours) {
  std::vector<Captioned> plots;
  for (const Tour& tour : tours) plots.push_back({tour_plot(field, neck, limits, tour), tour.caption});
  return strip(plots);
}

}  // namespace headway::app
