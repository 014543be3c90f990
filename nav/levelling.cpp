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
// A rival is believed when it rests on as many views as what was known, but at least and at most:
constexpr int kFewestViews = 20;
constexpr double kLongestRivalry = 10;  // [s]

}  // namespace

/// What one view's floor tells of the pose it was taken with: told = by_state * (error - error_taken_out).
struct Levelling::Observation {
  Vector3d told;
  Vector3d taken_out;
  Matrix3d by_state, noise;
};

/// A plane that rises with slope (a, b) is made level by a turn of (-b, a) about the map's x and y axes,
/// which is the view's own turn, seen from the map.
Levelling::Observation Levelling::observation(const FloorPlane& plane, const Matrix3d& map_from_view,
                                              const Vector3d& taken_out) {
  Matrix3d by_plane = Matrix3d::Zero();
  by_plane(0, 2) = -1;
  by_plane(1, 1) = 1;
  by_plane(2, 0) = 1;
  Observation o;
  o.told = by_plane * Vector3d(plane.height, plane.slope.x(), plane.slope.y());
  o.taken_out = taken_out;
  o.noise = by_plane * plane.covariance * by_plane.transpose() +
            Matrix3d(Vector3d(kViewTilt, kViewTilt, kViewHeight).cwiseAbs2().asDiagonal());
  o.by_state = Matrix3d::Zero();
  o.by_state.block<2, 1>(0, 0) = map_from_view.block<2, 1>(0, 0);
  o.by_state.block<2, 1>(0, 1) = map_from_view.block<2, 1>(0, 2);
  o.by_state(2, 2) = 1;
  return o;
}

Levelling::Belief Levelling::nothing_known() const {
  const double tilt = config_.fit.widest_tilt / 2, height = config_.fit.greatest_height / 2;
  Belief belief;
  belief.covariance = Vector3d(tilt, tilt, height).cwiseAbs2().asDiagonal();
  return belief;
}

Levelling::Levelling(const LevellingConfig& config)
    : config_(config), fitter_(config.fit), known_(nothing_known()), rival_(known_) {}

Eigen::Isometry3d Levelling::levelled(const Eigen::Isometry3d& map_from_view) const {
  const Vector3d turn(known_.state.x(), 0, known_.state.y());
  Eigen::Isometry3d pose = map_from_view;
  pose.translation().z() -= known_.state.z();
  if (const double angle = turn.norm(); angle > 0) pose.rotate(Eigen::AngleAxisd(angle, turn / angle));
  return pose;
}

Eigen::Isometry3d Levelling::level(const vision::RangeView& view, const Eigen::Isometry3d& map_from_view,
                                   Time stamp) {
  if (!config_.use) return map_from_view;
  const double seconds = begun_ ? std::clamp(to_seconds(stamp - last_), 0.0, kLongest) : 0;
  for (Belief* belief : {&known_, &rival_})
    belief->covariance +=
        seconds * Matrix3d(Vector3d(kTiltWalk, kTiltWalk, kHeightWalk).cwiseAbs2().asDiagonal());
  begun_ = true;
  last_ = stamp;
  const Eigen::Isometry3d known = levelled(map_from_view);
  const FloorFit fit = fitter_.fit(view, known);
  sight_ = fit.sight;
  if (fit.sight == FloorSight::kTooFew)
    ++counters_.unseen;
  else if (fit && learn(observation(fit.plane, known.linear(), known_.state), seconds))
    ++counters_.fitted;
  else
    ++counters_.refused;
  return levelled(map_from_view);
}

/// False when the view was refused.
bool Levelling::learn(const Observation& floor, double seconds) {
  if (learn(floor, seconds, known_)) {
    rival_ = nothing_known();
    return true;
  }
  if (!learn(floor, seconds, rival_)) {
    rival_ = nothing_known();
    learn(floor, seconds, rival_);
  }
  const bool outlasts = rival_.views >= known_.views || rival_.seconds >= kLongestRivalry;
  if (rival_.views < kFewestViews || !outlasts) return false;
  known_ = rival_;
  rival_ = nothing_known();
  ++counters_.revised;
  return true;
}

bool Levelling::learn(const Observation& floor, double seconds, Belief& belief) const {
  const Vector3d told = floor.told + floor.by_state * (floor.taken_out - belief.state);
  const Matrix3d expected = floor.by_state * belief.covariance * floor.by_state.transpose() + floor.noise;
  const Matrix3d certainty = expected.inverse();
  if (!(told.dot(certainty * told) <= kGate)) return false;
  const Matrix3d gain = belief.covariance * floor.by_state.transpose() * certainty;
  const Vector3d state = belief.state + gain * told;
  if (!within_limits(state)) return false;
  belief.state = state;
  belief.covariance -= gain * floor.by_state * belief.covariance;
  belief.covariance = (belief.covariance + belief.covariance.transpose()).eval() / 2;
  belief.seconds += belief.views++ > 0 ? seconds : 0;
  return true;
}

bool Levelling::within_limits(const Vector3d& state) const {
  return state.head<2>().norm() <= config_.fit.widest_tilt &&
         std::abs(state.z()) <= config_.fit.greatest_height;
}

}  // namespace headway::nav
