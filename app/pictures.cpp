#include "app/pictures.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace headway::app {

namespace {

constexpr double kSharpest = 0.001, kBlurriest = 1.0;  // the uncertainties that the colours span [m]

struct Span {
  double lowest, highest;
};

/// Most of the depths that are measured within the view's limits: stray points must not stretch the colours.
Span depth_span(const vision::RangeView& view) {
  std::vector<float> depths;
  for (const float z : view.depth) {
    const auto depth = static_cast<double>(z);
    if (depth >= view.near && depth <= view.far) depths.push_back(z);
  }
  if (depths.empty()) return {view.near, std::max(view.far, view.near + 0.1)};
  const auto at_share = [&](double share) {
    const auto n = static_cast<std::ptrdiff_t>(share * static_cast<double>(depths.size() - 1));
    std::nth_element(depths.begin(), depths.begin() + n, depths.end());
    return static_cast<double>(depths[static_cast<std::size_t>(n)]);
  };
  const double lowest = at_share(0.01), highest = at_share(0.99);
  return {lowest, std::max(highest, lowest + 0.1)};
}

double measured_share(const vision::RangeView& view) {
  const auto n =
      std::count_if(view.depth.begin(), view.depth.end(), [](float z) { return std::isfinite(z); });
  return view.depth.empty() ? 0 : static_cast<double>(n) / static_cast<double>(view.depth.size());
}

/// A picture of the view's size; `colour_of(u, v)` is asked where something was measured.
template <class ColourOf>
cv::Mat painted(const vision::RangeView& view, const ColourOf& colour_of) {
  cv::Mat out = canvas(view.camera.width, view.camera.height, colours::kBackground);
  for (int v = 0; v < view.camera.height; ++v) {
    for (int u = 0; u < view.camera.width; ++u) {
      if (std::isfinite(view.depth[view.index(u, v)])) out.at<Colour>(v, u) = colour_of(u, v);
    }
  }
  return out;
}

}  // namespace

cv::Mat image_picture(const hal::GrayImage& image) {
  cv::Mat out(image.height, image.width, CV_8UC3);
  std::size_t i = 0;
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) out.at<Colour>(v, u) = Colour::all(image.pixels[i++]);
  }
  return out;
}

cv::Mat depth_picture(const vision::RangeView& view) {
  const auto [lowest, highest] = depth_span(view);
  const cv::Mat depths = painted(view, [&](int u, int v) {
    const auto z = static_cast<double>(view.depth[view.index(u, v)]);
    return ramp_colour(Ramp::kViridis, (z - lowest) / (highest - lowest));
  });
  const std::string title = fmt::format("depth [m], {:.1f} % measured from {:g} to {:g} m (dark: not)",
                                        100 * measured_share(view), view.near, view.far);
  return with_legend(depths, title, Ramp::kViridis, linear_ticks(lowest, highest, 8));
}

double uncertainty(const vision::RangeView& view, int u, int v) {
  if (!std::isfinite(view.depth[view.index(u, v)])) return std::numeric_limits<double>::quiet_NaN();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(view.covariance(u, v), Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()(2)));
}

cv::Mat uncertainty_picture(const vision::RangeView& view) {
  const double range = std::log(kBlurriest / kSharpest);
  const cv::Mat sigmas = painted(view, [&](int u, int v) {
    const double sigma = std::max(uncertainty(view, u, v), kSharpest);
    // The ramp's black is kept for what was not measured.
    return ramp_colour(Ramp::kInferno, std::max(0.08, std::log(sigma / kSharpest) / range));
  });
  return with_legend(sigmas, "uncertainty of each point: largest standard deviation", Ramp::kInferno,
                     logarithmic_length_ticks(kSharpest, kBlurriest));
}

std::vector<Eigen::Vector2d> polyline(const nav::Path& path, const nav::FloorGrid& grid) {
  std::vector<Eigen::Vector2d> line;
  if (path.states.empty()) return line;
  line.push_back(path.start.position());
  for (const nav::PathState& state : path.states) {
    const Eigen::Vector2d centre = grid.centre(state.cell);
    if (line.size() == 1 || !line.back().isApprox(centre)) line.push_back(centre);
  }
  line.push_back(path.end);
  return line;
}

std::vector<FootPrint> foot_prints(const nav::Walk& walk, std::size_t committed) {
  std::vector<FootPrint> feet;
  for (std::size_t i = 0; i < walk.steps.size(); ++i) {
    const hal::Foot foot = walk.steps[i].foot;
    feet.push_back({walk.stances[i].at(foot), foot, i < committed});
  }
  return feet;
}

void add_stance(const hal::Stance& stance, std::vector<FootPrint>& feet) {
  feet.push_back({stance.left, hal::Foot::kLeft, true});
  feet.push_back({stance.right, hal::Foot::kRight, true});
}

}  // namespace headway::app
