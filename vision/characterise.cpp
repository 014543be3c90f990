#include "vision/characterise.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

#include "vision/hull.h"
#include "vision/triangulation.h"

namespace headway::vision {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

template <class Rig>
std::array<PolytopeSize, 3> sizes(const Rig& rig, double near, double far) {
  const std::array<FieldLimits, 3> limits{FieldLimits{}, FieldLimits{near}, FieldLimits{near, far}};
  std::array<PolytopeSize, 3> out;
  std::transform(limits.begin(), limits.end(), out.begin(), [&](const FieldLimits& l) {
    const Polytope polytope = rig_polytope(rig, l);
    return PolytopeSize{polytope.rows.size(), polytope.corners.size()};
  });
  return out;
}

// Of a camera like `c` whose principal point lies `offset` pixels further right and which stands `baseline`
// to the right of it.
ProjectionMatrix projection(const PinholeCamera& c, double offset, double baseline) {
  ProjectionMatrix p;
  p << c.focal, 0, c.cx + offset, -c.focal * baseline, 0, c.focal, c.cy, 0, 0, 0, 1, 0;
  return p;
}

// Resolution grows away from the axis: it is worst in a corner of the common view.
double worst_resolution(const RectifiedRig& rig, double z) {
  const PinholeCamera& c = rig.camera;
  const double shift = rig.disparity(z);  // the right image's columns, seen in the left one
  const double u0 = std::max(-0.5, shift - 0.5), u1 = std::min(c.width - 0.5, c.width - 0.5 + shift);
  if (u0 >= u1) return 0;
  double worst = 0;
  for (const double u : {u0, u1})
    for (const double v : {-0.5, c.height - 0.5}) worst = std::max(worst, resolution(rig, c.point(u, v, z)));
  return worst;
}

SightAt sight_at(const RectifiedRig& rig, double z) {
  return {z, field_angles(rig, z), resolution(rig, on_axis(rig, z)), worst_resolution(rig, z),
          measured_resolution(rig, z)};
}

std::vector<SightAt> sights(const RectifiedRig& rig) {
  constexpr int kDepths = 24;
  std::vector<SightAt> out;
  out.reserve(kDepths);
  for (int i = 0; i < kDepths; ++i)
    out.push_back(sight_at(rig, rig.nearest * std::pow(rig.farthest / rig.nearest, i / (kDepths - 1.0))));
  return out;
}

void move(PixelPairField& pairs, const Eigen::Isometry3d& to_from_pairs) {
  const Matrix3d r = to_from_pairs.linear();
  for (UncertainPoint& p : pairs.points) {
    p.position = to_from_pairs * p.position;
    p.covariance = r * p.covariance * r.transpose();
  }
  pairs.hull = moved(pairs.hull, to_from_pairs);
  pairs.minimal = moved(pairs.minimal, to_from_pairs);
}

}  // namespace

Characteristics characterise(const Rectifier& rectifier, const std::vector<double>& resolutions) {
  const StereoRig& rig = rectifier.raw();
  const RectifiedRig& rectified = rectifier.rig();
  const double near = rig.nearest, far = rig.farthest;
  Characteristics out;
  out.rectified = rectified;
  out.field = rig_polytope(rectified, {near, far});
  out.rectified_sizes = sizes(rectified, near, far);
  out.mounted_sizes = sizes(rig, near, far);
  const DisparityRange range = disparity_range(rectified);
  out.matcher_columns = std::clamp(range.lowest + range.count, 0, rectified.camera.width - 1);
  out.padded_share =
      1 - volume(rig_polytope(rectified, {near, far, out.matcher_columns})) / volume(out.field);
  PixelPairConfig config;
  config.pixel_sigma = rig.disparity_sigma / std::sqrt(2.0);  // a disparity is the difference of two
  out.pairs = pixel_pair_field(rig, {near, far}, config);
  move(out.pairs, rectifier.rectified_from_left());
  out.sights = sights(rectified);
  for (const double finest : resolutions) {
    auto polytope = resolution_polytope(rectified, out.field, finest);
    if (!polytope) continue;
    double farthest = 0;
    for (const Vector3d& corner : polytope->corners) farthest = std::max(farthest, corner.z());
    out.resolved.push_back({finest, *std::move(polytope), farthest});
  }
  return out;
}

Vector3d on_axis(const RectifiedRig& rig, double z) {
  return {rig.baseline / 2, ((rig.camera.height - 1) / 2.0 - rig.camera.cy) / rig.camera.focal * z, z};
}

double measured_resolution(const RectifiedRig& rig, double z, int draws) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> disparity_error(0, rig.disparity_sigma);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  const ProjectionMatrix left = projection(rig.camera, 0, 0),
                         right = projection(rig.camera, rig.disparity_offset, rig.baseline);
  const Vector3d truth = on_axis(rig, z);
  const Eigen::Vector2d in_left = (left * truth.homogeneous()).hnormalized(),
                        in_right = (right * truth.homogeneous()).hnormalized();
  Vector3d sum = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();
  int count = 0;
  for (int i = 0; i < draws; ++i) {
    const Eigen::Vector2d inside(place(random), place(random)), wrong(disparity_error(random), 0);
    const auto point =
        triangulate(left, right, in_left + inside, in_right + inside - wrong, rig.disparity_sigma);
    if (!point) continue;
    const Vector3d away = point->position - truth;
    sum += away, squares += away * away.transpose();
    ++count;
  }
  const Vector3d mean = sum / count;
  const Matrix3d covariance = squares / count - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues()(2));
}

double volume(const Polytope& polytope) {
  const TriangleMesh mesh = hull_mesh(polytope.corners);
  double six = 0;
  for (const auto& t : mesh.triangles)
    six += mesh.corners[t[0]].dot(mesh.corners[t[1]].cross(mesh.corners[t[2]]));
  return six / 6;
}

}  // namespace headway::vision
