#include "nav/levelling.h"

#include <algorithm>
#include <cmath>

#include "hal/angle.h"

namespace headway::nav {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

// Standard deviations of what a whole view errs: the floor's own unevenness, and the stereo's bias.
constexpr double kViewTilt = 0.12 * kDegree, kViewHeight = 0.003;  // [rad], [m]
// And of how the errors walk, within a second.
constexpr double kTiltWalk = 0.01 * kDegree, kHeightWalk = 0.0002;  // [rad], [m]
constexpr double kGate = 16;      // squared distance of what a view tells from what is known, in sigma
constexpr double kLongest = 1.0;  // [s] between views for which the walk counts

}  // namespace

Levelling::Levelling(const LevellingConfig& config) : config_(config), fitter_(config.fit) {
  const double tilt = config.fit.widest_tilt / 2, height = config.fit.greatest_height / 2;
  covariance_ = Vector3d(tilt, tilt, height).cwiseAbs2().asDiagonal();
}

Eigen::Isometry3d Levelling::levelled(const Eigen::Isometry3d& map_from_view) const {
  const Vector3d turn(state_.x(), 0, state_.y());
  Eigen::Isometry3d pose = map_from_view;
  pose.translation().z() -= state_.z();
  if (const double angle = turn.norm(); angle > 0) pose.rotate(Eigen::AngleAxisd(angle, turn / angle));
  return pose;
}

Eigen::Isometry3d Levelling::level(const vision::RangeView& view, const Eigen::Isometry3d& map_from_view,
                                   Time stamp) {
  if (!config_.use) return map_from_view;
  if (begun_) {
    const double time = std::clamp(to_seconds(stamp - last_), 0.0, kLongest);
    covariance_ += time * Matrix3d(Vector3d(kTiltWalk, kTiltWalk, kHeightWalk).cwiseAbs2().asDiagonal());
  }
  begun_ = true;
  last_ = stamp;
  const Eigen::Isometry3d known = levelled(map_from_view);
  const FloorFit fit = fitter_.fit(view, known);
  sight_ = fit.sight;
  if (fit.sight == FloorSight::kTooFew)
    ++counters_.unseen;
  else if (fit && learn(fit.plane, known.linear()))
    ++counters_.fitted;
  else
    ++counters_.refused;
  return levelled(map_from_view);
}

/// A plane that rises with slope (a, b) is made level by a turn of (-b, a) about the map's x and y axes,
/// which is the view's own turn, seen from the map.
bool Levelling::learn(const FloorPlane& plane, const Matrix3d& map_from_view) {
  Matrix3d told_by_plane = Matrix3d::Zero();
  told_by_plane(0, 2) = -1;
  told_by_plane(1, 1) = 1;
  told_by_plane(2, 0) = 1;
  const Vector3d told = told_by_plane * Vector3d(plane.height, plane.slope.x(), plane.slope.y());
  const Matrix3d noise = told_by_plane * plane.covariance * told_by_plane.transpose() +
                         Matrix3d(Vector3d(kViewTilt, kViewTilt, kViewHeight).cwiseAbs2().asDiagonal());
  Matrix3d told_by_state = Matrix3d::Zero();
  told_by_state.block<2, 1>(0, 0) = map_from_view.block<2, 1>(0, 0);
  told_by_state.block<2, 1>(0, 1) = map_from_view.block<2, 1>(0, 2);
  told_by_state(2, 2) = 1;
  const Matrix3d expected = told_by_state * covariance_ * told_by_state.transpose() + noise;
  const Matrix3d certainty = expected.inverse();
  if (!(told.dot(certainty * told) <= kGate)) return false;
  const Matrix3d gain = covariance_ * told_by_state.transpose() * certainty;
  const Vector3d state = state_ + gain * told;
  if (!within_limits(state)) return false;
  state_ = state;
  covariance_ -= gain * told_by_state * covariance_;
  covariance_ = (covariance_ + covariance_.transpose()).eval() / 2;
  return true;
}

bool Levelling::within_limits(const Vector3d& state) const {
  return state.head<2>().norm() <= config_.fit.widest_tilt &&
         std::abs(state.z()) <= config_.fit.greatest_height;
}

}  // namespace headway::nav
