#include "app/surface_picture.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "app/drawing.h"
#include "app/pictures.h"
#include "app/scene_picture.h"

namespace headway::app {

namespace {

using Eigen::Vector3d;

constexpr double kTear = 0.03;  // depth step, as a share of the depth, over which the surface is not spanned
constexpr double kSigmas = 10;  // three would hardly be seen
constexpr int kAcross = 26;     // ellipsoids along the image's width

bool shown(const vision::RangeView& view, int u, int v) {
  return static_cast<double>(view.depth[view.index(u, v)]) <= view.far;  // false for NaN
}

Vector3d point(const vision::RangeView& view, int u, int v) {
  return upright(view.camera.point(u, v, static_cast<double>(view.depth[view.index(u, v)])));
}

void draw_surface(ScenePicture& scene, const vision::RangeView& view, const hal::GrayImage& left) {
  using Pixel = std::array<int, 2>;
  const auto span = [&](const std::array<Pixel, 3>& at) {
    std::array<Vector3d, 3> corners;
    std::array<Colour, 3> colours;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [u, v] = at[i];
      if (!shown(view, u, v)) return;
      corners[i] = point(view, u, v);
      colours[i] = Colour::all(left.pixels[view.index(u, v)]);
    }
    const auto [nearest, farthest] = std::minmax({corners[0].x(), corners[1].x(), corners[2].x()});
    if (farthest - nearest < kTear * nearest) scene.triangle(corners, colours);
  };
  for (int v = 0; v + 1 < view.camera.height; ++v)
    for (int u = 0; u + 1 < view.camera.width; ++u) {
      span({{{u, v}, {u, v + 1}, {u + 1, v}}});
      span({{{u + 1, v}, {u, v + 1}, {u + 1, v + 1}}});
    }
}

/// Quads of a unit sphere, each as two triangles.
std::vector<std::array<Vector3d, 3>> sphere() {
  constexpr int kRound = 14, kUp = 8;
  const auto at = [](int i, int j) {
    const double a = 2 * M_PI * i / kRound, e = M_PI * j / kUp;
    return Vector3d(std::sin(e) * std::cos(a), std::sin(e) * std::sin(a), std::cos(e));
  };
  std::vector<std::array<Vector3d, 3>> triangles;
  for (int i = 0; i < kRound; ++i)
    for (int j = 0; j < kUp; ++j) {
      triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return triangles;
}

struct Span {
  double lowest, highest;
  double share(double v) const {
    return std::clamp(std::log(v / lowest) / std::log(highest / lowest), 0.0, 1.0);
  }
};

/// Most of the points' resolutions: a few far ones must not stretch the colours.
Span resolutions(const vision::RangeView& view) {
  std::vector<double> all;
  for (int v = 0; v < view.camera.height; v += 8)
    for (int u = 0; u < view.camera.width; u += 8)
      if (shown(view, u, v)) all.push_back(uncertainty(view, u, v));
  if (all.size() < 2) return {1e-3, 1e-2};
  std::sort(all.begin(), all.end());
  const double lowest = all[all.size() / 50];
  return {lowest, std::max(all[all.size() - 1 - all.size() / 50], 1.1 * lowest)};
}

Colour colour_of(double share) { return ramp_colour(Ramp::kInferno, 0.2 + 0.68 * share); }

void draw_ellipsoids(ScenePicture& scene, const vision::RangeView& view, const Span& sigmas) {
  const auto triangles = sphere();
  const int step = std::max(1, view.camera.width / kAcross);
  for (int v = step / 2; v < view.camera.height; v += step)
    for (int u = step / 2; u < view.camera.width; u += step) {
      if (!shown(view, u, v)) continue;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(view.covariance(u, v));
      const Eigen::Matrix3d shape = kSigmas * solver.operatorSqrt();
      const Colour colour = colour_of(sigmas.share(uncertainty(view, u, v)));
      const Vector3d centre = point(view, u, v);
      for (const auto& t : triangles)
        scene.lit_triangle(
            {centre + upright(shape * t[0]), centre + upright(shape * t[1]), centre + upright(shape * t[2])},
            colour);
    }
}

/// From beside the camera, as near as it can be while nearly all that is shown is in the picture: a few stray
/// points must not make the rest small.
Lookout beside_the_camera(const vision::RangeView& view, int width, int height) {
  std::vector<Vector3d> points;
  for (int v = 0; v < view.camera.height; v += 4)
    for (int u = 0; u < view.camera.width; u += 4)
      if (shown(view, u, v)) points.push_back(point(view, u, v));
  if (points.empty()) points.push_back({(view.near + view.far) / 2, 0, 0});
  Eigen::AlignedBox3d most;
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::sort(points, {}, [&](const Vector3d& p) { return p[axis]; });
    const std::size_t few = points.size() / 200;
    most.min()[axis] = points[few][axis];
    most.max()[axis] = points[points.size() - 1 - few][axis];
  }
  std::erase_if(points, [&](const Vector3d& p) { return !most.contains(p); });
  if (points.size() < 2) points = {most.min(), most.max() + Vector3d::Ones()};
  return framing(points, -2.63, 0.29, width, height, 0.6);
}

}  // namespace

cv::Mat surface_picture(const vision::RangeView& view, const hal::GrayImage& left) {
  constexpr int kWidth = 520, kHeight = 430;
  const Lookout from = beside_the_camera(view, kWidth, kHeight);
  ScenePicture plain(from, kWidth, kHeight);
  draw_surface(plain, view, left);
  ScenePicture with = plain;
  const Span sigmas = resolutions(view);
  draw_ellipsoids(with, view, sigmas);
  cv::Mat image = with.finished();
  std::vector<Key> keys;
  for (int i = 3; i >= 0; --i) {
    const double sigma = sigmas.lowest * std::pow(sigmas.highest / sigmas.lowest, i / 3.0);
    keys.push_back({colour_of(i / 3.0), fmt::format("{:.0f} mm", sigma * 1e3)});
  }
  const Colour paper = colours::kPaper;
  image(cv::Rect(0, 0, 112, 122)).setTo(cv::Scalar(paper[0], paper[1], paper[2]));
  draw_text(image, "resolution", {12, 20}, colours::kInk, 10);
  draw_keys(image, {12, 28}, keys, colours::kInk);
  return strip({{plain.finished(), "the reconstructed surface"},
                {image, "with ellipsoids of ten standard deviations"}});
}

}  // namespace headway::app
