#include "vision/head_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "hal/error.h"
#include "vision/board_pose.h"
#include "vision/head_observability.h"
#include "vision/least_squares.h"

namespace headway::vision {

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Where the parameters stand in the vector that is solved for; the board's six come first.
enum Place : Eigen::Index {
  kBoard = 0,
  kX = 6,
  kY,
  kZ,
  kTurnX,
  kTurnZ,
  kTiltZero,
  kTimeOffset,
  kPanZero,
  kAll
};

constexpr double kFirstSigma = 0.3;  // [px] of a corner, until the residuals tell

struct Parameter {
  const char *name, *unit;
  double step;    // for derivatives
  double useful;  // a standard deviation above this is of no use
};
constexpr double kUsefulTurn = 0.25 * std::numbers::pi / 180, kUsefulLength = 0.01, kUsefulTime = 0.01;
constexpr std::array<Parameter, kAll - kX> kParameters{{{"camera.x", "m", 1e-5, kUsefulLength},
                                                        {"camera.y", "m", 1e-5, kUsefulLength},
                                                        {"camera.z", "m", 1e-5, kUsefulLength},
                                                        {"camera.turn_x", "rad", 1e-5, kUsefulTurn},
                                                        {"camera.turn_z", "rad", 1e-5, kUsefulTurn},
                                                        {"tilt_zero", "rad", 1e-5, kUsefulTurn},
                                                        {"time_offset", "s", 1e-4, kUsefulTime},
                                                        {"pan_zero", "rad", 1e-5, kUsefulTurn}}};
const Parameter& parameter(Eigen::Index place) { return kParameters[static_cast<std::size_t>(place - kX)]; }

double seconds_between(Time from, Time to) { return to_seconds(to - from); }

/// Slope [rad/s] at a sample, from its neighbours.
double slope(const std::vector<HeadSample>& samples, std::size_t i, double hal::HeadAngles::*joint) {
  const HeadSample &before = samples[i > 0 ? i - 1 : i],
                   &after = samples[std::min(i + 1, samples.size() - 1)];
  return (after.angles.*joint - before.angles.*joint) / seconds_between(before.stamp, after.stamp);
}

/// Cubic between samples (Hermite's, with the slopes of their neighbours): chords would cut the corners where
/// the head turns back, as if its angles were smaller. The first and the last sample beyond them.
hal::HeadAngles angles_at(const std::vector<HeadSample>& samples, Time start, double t) {
  const auto later = std::upper_bound(samples.begin(), samples.end(), t, [&](double at, const HeadSample& s) {
    return at < seconds_between(start, s.stamp);
  });
  if (later == samples.begin()) return samples.front().angles;
  if (later == samples.end()) return samples.back().angles;
  const auto b = static_cast<std::size_t>(later - samples.begin()), a = b - 1;
  const double h = seconds_between(samples[a].stamp, samples[b].stamp);
  const double s = (t - seconds_between(start, samples[a].stamp)) / h;
  const auto cubic = [&](double hal::HeadAngles::*joint) {
    const double from = samples[a].angles.*joint, to = samples[b].angles.*joint;
    return from + s * s * (3 - 2 * s) * (to - from) +
           h * s * (1 - s) * ((1 - s) * slope(samples, a, joint) - s * slope(samples, b, joint));
  };
  return {cubic(&hal::HeadAngles::pan), cubic(&hal::HeadAngles::tilt)};
}

class Problem {
 public:
  explicit Problem(const HeadCalibrationInput& input) : in_(input), start_(input.samples.front().stamp) {
    const HeadView& first = in_.views.front();
    guess_ =
        in_.neck.chest_from_camera(angles(first, 0)) * camera_from_board(in_.camera, in_.board, first.board);
    for (const HeadView& view : in_.views) pixels_ += 2 * static_cast<Eigen::Index>(view.board.size());
  }

  Eigen::Index size() const { return in_.corner ? kAll : kPanZero; }
  VectorXd steps() const {
    VectorXd out = VectorXd::Constant(size(), 1e-5);
    for (Eigen::Index i = kX; i < size(); ++i) out(i) = parameter(i).step;
    return out;
  }

  hal::HeadAngles angles(const HeadView& view, double offset) const {
    return angles_at(in_.samples, start_, seconds_between(start_, view.exposure) + offset);
  }

  hal::HeadKinematics neck(const VectorXd& x) const {
    hal::HeadKinematics neck = in_.neck;
    neck.zero.tilt += x(kTiltZero);
    if (in_.corner) neck.zero.pan += x(kPanZero);
    Isometry3d& camera = neck.tilt_from_camera;
    const Vector3d turn(x(kTurnX), 0, x(kTurnZ));
    if (turn.norm() > 0)
      camera.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * camera.linear();
    camera.translation() += x.segment<3>(kX);
    return neck;
  }

  Isometry3d chest_from_board(const VectorXd& x) const { return moved(guess_, x.head<6>()); }

  VectorXd of_view(const VectorXd& x, const HeadView& view) const {
    const Isometry3d chest_from_camera = neck(x).chest_from_camera(angles(view, x(kTimeOffset)));
    return reprojection_residuals(in_.camera, chest_from_camera.inverse() * chest_from_board(x), in_.board,
                                  view.board);
  }

  /// All residuals over their standard deviations: corners, then the measured one.
  VectorXd residuals(const VectorXd& x, double sigma) const {
    VectorXd out(pixels_ + (in_.corner ? 3 : 0));
    Eigen::Index at = 0;
    for (const HeadView& view : in_.views) {
      const VectorXd of = of_view(x, view);
      out.segment(at, of.size()) = of / sigma;
      at += of.size();
    }
    if (in_.corner)
      out.tail<3>() = (chest_from_board(x).translation() - in_.corner->place) / in_.corner->sigma;
    return out;
  }

  /// From several time offsets on, for the head's motion is not monotonic. Throws InputError when none leads
  /// to a minimum.
  LeastSquares solve(double sigma) const {
    LeastSquares best;
    double least = std::numeric_limits<double>::infinity();
    for (const double offset : {0.0, -0.1, 0.1}) {
      VectorXd x = VectorXd::Zero(size());
      x(kTimeOffset) = offset;
      LeastSquares found = minimise([&](const VectorXd& at) { return residuals(at, sigma); }, x, steps());
      if (const double squares = found.residuals.squaredNorm(); squares < least)  // not where it is NaN
        least = squares, best = std::move(found);
    }
    if (!best.settled || !best.information.allFinite())
      throw InputError(
          "head calibration: the search for the camera's place does not settle; expected the board, the rig "
          "and the robot file that belong to these images");
    return best;
  }

  /// Standard deviation of one coordinate of a corner, as the residuals show it.
  double sigma_of(const VectorXd& x) const {
    const double squares = residuals(x, 1).head(pixels_).squaredNorm();
    return std::sqrt(squares / std::max(1.0, static_cast<double>(pixels_ - size())));
  }

  HeadMotion motion(double offset) const {
    HeadMotion out;
    for (const HeadView& view : in_.views) {
      const double step = 0.01;
      const hal::HeadAngles at = angles(view, offset), before = angles(view, offset - step),
                            after = angles(view, offset + step);
      out.add(at, std::hypot(after.pan - before.pan, after.tilt - before.tilt) / (2 * step));
    }
    return out;
  }

 private:
  const HeadCalibrationInput& in_;
  Time start_;
  Isometry3d guess_;
  Eigen::Index pixels_ = 0;
};

/// What the views say of the wanted parameters when nothing is known of the board.
Eigen::MatrixXd without_board(const Eigen::MatrixXd& information) {
  const Eigen::Index n = information.rows() - kX;
  const Eigen::MatrixXd cross = information.topRightCorner(kX, n);
  return information.bottomRightCorner(n, n) -
         cross.transpose() * information.topLeftCorner<kX, kX>().ldlt().solve(cross);
}

void require_determined(const Eigen::MatrixXd& information, const HeadMotion& motion) {
  std::vector<std::string> names;
  VectorXd useful(information.rows());
  for (Eigen::Index i = 0; i < information.rows(); ++i) {
    names.emplace_back(parameter(kX + i).name);
    useful(i) = parameter(kX + i).useful;
  }
  const std::vector<std::string> missing = undetermined(information, useful, names);
  if (missing.empty()) return;
  throw InputError(fmt::format("head calibration: the views do not determine {}; {}",
                               fmt::join(missing, ", "), motion.advice()));
}

void check(const HeadCalibrationInput& input) {
  require_usable(input.board);
  const auto fail = [](const std::string& what) { throw InputError("head calibration: " + what); };
  if (input.views.size() < kFewestHeadViews)
    fail(fmt::format("the board is seen in {} views, expected {} or more", input.views.size(),
                     kFewestHeadViews));
  for (const HeadView& view : input.views) {
    if (!shows_enough(input.board, view.board))
      fail("a view shows too few corners, expected 6 not in one line");
    if (!samples_cover(input.samples, view.exposure))
      fail(fmt::format(
          "no head samples around {:.3f} s, expected them {} s to both sides, {} s apart at most",
          to_seconds(view.exposure), to_seconds(kWidestTimeOffset), to_seconds(kWidestSampleGap)));
  }
  if (input.corner &&
      !(input.corner->place.allFinite() && input.corner->sigma > 0 && std::isfinite(input.corner->sigma)))
    fail("the measured corner and its sigma must be finite, the sigma positive");
}

}  // namespace

bool samples_cover(const std::vector<HeadSample>& samples, Time exposure) {
  const auto by_stamp = [](const HeadSample& s, Time t) { return s.stamp < t; };
  auto at = std::lower_bound(samples.begin(), samples.end(), exposure - kWidestTimeOffset, by_stamp);
  if (at == samples.end()) return false;
  if (at->stamp > exposure - kWidestTimeOffset && at != samples.begin()) --at;
  if (at->stamp > exposure - kWidestTimeOffset) return false;
  for (; at + 1 != samples.end(); ++at) {
    if (at->stamp >= exposure + kWidestTimeOffset) return true;
    if ((at + 1)->stamp - at->stamp > kWidestSampleGap) return false;
  }
  return at->stamp >= exposure + kWidestTimeOffset;
}

HeadCalibration calibrate_head(const HeadCalibrationInput& input) {
  check(input);
  const Problem problem(input);
  const double sigma = problem.sigma_of(problem.solve(kFirstSigma).x);
  const LeastSquares found = problem.solve(std::max(sigma, 1e-6));
  const Eigen::MatrixXd information = without_board(found.information);
  require_determined(information, problem.motion(found.x(kTimeOffset)));
  if (std::abs(found.x(kTimeOffset)) >= to_seconds(kWidestTimeOffset))
    throw InputError(fmt::format(
        "head calibration: the stamps of camera and bus differ by {:.3f} s, expected at most {} s",
        found.x(kTimeOffset), to_seconds(kWidestTimeOffset)));
  HeadCalibration out;
  out.neck = problem.neck(found.x);
  out.time_offset = seconds(found.x(kTimeOffset));
  out.chest_from_board = problem.chest_from_board(found.x);
  out.rms = std::sqrt(2.0) * sigma;
  const VectorXd variances = information.inverse().diagonal();
  for (Eigen::Index i = kX; i < problem.size(); ++i)
    out.estimates.push_back({parameter(i).name, found.x(i), std::sqrt(variances(i - kX)), parameter(i).unit});
  for (const HeadView& view : input.views) {
    const VectorXd residuals = problem.of_view(found.x, view);
    out.view_angles.push_back(problem.angles(view, found.x(kTimeOffset)));
    out.view_rms.push_back(std::sqrt(2 * residuals.squaredNorm() / static_cast<double>(residuals.size())));
  }
  return out;
}

}  // namespace headway::vision
