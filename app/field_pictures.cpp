#include "app/field_pictures.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "app/plot.h"
#include "app/resolution_scale.h"
#include "app/scene_picture.h"

namespace headway::app {

namespace {

using Eigen::Vector3d;

double resolution_of(const vision::UncertainPoint& point) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(point.covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(solver.eigenvalues()(2), 1e-18));
}

void draw_camera(ScenePicture& scene, const vision::PinholeCamera& camera, const Vector3d& at, double size) {
  std::vector<Vector3d> corners;
  for (const double v : {-0.5, camera.height - 0.5})
    for (const double u : {-0.5, camera.width - 0.5})
      corners.push_back(upright(at + camera.point(u, v, size)));
  for (const Vector3d& corner : corners) scene.line(upright(at), corner, colours::kBlue, 1.5, 1);
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

}  // namespace

std::vector<ColouredPoint> coloured_points(const vision::Characteristics& rig) {
  const ResolutionScale scale(rig);
  std::vector<ColouredPoint> points;
  for (const vision::UncertainPoint& p : rig.pairs.points)
    points.push_back({p.position, scale.colour(resolution_of(p))});
  return points;
}

cv::Mat field_picture(const vision::Characteristics& rig) {
  constexpr int kWidth = 860, kHeight = 560;
  Eigen::AlignedBox3d box(Vector3d::Zero());
  for (const Vector3d& corner : rig.field.corners) box.extend(upright(corner));
  const Ground ground(box);
  std::vector<Vector3d> all = ground.corners();
  for (const Vector3d& corner : rig.field.corners) all.push_back(upright(corner));
  ScenePicture scene(framing(all, -0.38 * std::numbers::pi, 0.2, kWidth, kHeight), kWidth, kHeight);
  ground.draw(scene);
  for (const ColouredPoint& p : coloured_points(rig)) scene.dot(upright(p.position), 1.3, p.colour);
  for (const auto& [i, j] : vision::edges(rig.field))
    scene.line(upright(rig.field.corners[i]), upright(rig.field.corners[j]), colours::kInk, 1.6, 0.55);
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
  return ResolutionScale(rig).beside({image});
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

}  // namespace headway::app
