#include "vision/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "vision/calibration_gaps.h"

namespace headway::vision {

namespace {

constexpr double kPoorestFocal = 0.05;  // share of the focal length that its standard deviation may be

cv::TermCriteria settled() { return {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-10}; }

/// Views as OpenCV takes them, and lenses as it finds them.
struct Corners {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> image;
};

void add(Corners& corners, const Board& board, const BoardView& view) {
  auto& at = corners.board.emplace_back();
  auto& seen = corners.image.emplace_back();
  for (std::size_t k = 0; k < view.size(); ++k) {
    const Eigen::Vector3f corner = board.corner(view.ids[k]).cast<float>();
    const Eigen::Vector2f pixel = view.pixels[k].cast<float>();
    at.emplace_back(corner.x(), corner.y(), corner.z());
    seen.emplace_back(pixel.x(), pixel.y());
  }
}

struct Lens {
  cv::Mat1d matrix, distortion;

  Lens() : Lens(CameraIntrinsics{}) {}
  explicit Lens(const CameraIntrinsics& c)
      : matrix((cv::Mat1d(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1)),
        distortion((cv::Mat1d(1, 5) << c.k1, c.k2, c.p1, c.p2, c.k3)) {}

  CameraIntrinsics camera(int width, int height) const {
    const cv::Mat1d &k = matrix, d = distortion.reshape(1, 1);
    CameraIntrinsics c;
    c.width = width, c.height = height;
    c.fx = k(0, 0), c.fy = k(1, 1), c.cx = k(0, 2), c.cy = k(1, 2);
    c.k1 = d(0, 0), c.k2 = d(0, 1), c.p1 = d(0, 2), c.p2 = d(0, 3), c.k3 = d(0, 4);
    return c;
  }
};

double rms(const Eigen::VectorXd& residuals) {
  return std::sqrt(2 * residuals.squaredNorm() / std::max<double>(1, static_cast<double>(residuals.size())));
}

[[noreturn]] void fail(const std::string& what) { throw InputError("calibration: " + what); }

void require_enough(std::size_t views) {
  if (views < kFewestViews)
    fail(fmt::format("the board is seen in {} views, expected at least {}, tilted differently", views,
                     kFewestViews));
}

struct CameraFit {
  Lens lens;
  cv::Mat1d sigma;
  double rms = 0;
  std::vector<double> view_rms;
};

CameraFit fit_camera(const Corners& corners, cv::Size size, int flags) {
  CameraFit fit;
  std::vector<cv::Mat> turns, places;
  cv::Mat sigma, of_poses, per_view;
  try {
    fit.rms = cv::calibrateCamera(corners.board, corners.image, size, fit.lens.matrix, fit.lens.distortion,
                                  turns, places, sigma, of_poses, per_view, flags, settled());
  } catch (const cv::Exception& e) {
    fail(fmt::format("the views determine no camera ({}); expected the board tilted differently in each",
                     e.err));
  }
  // OpenCV 4.6 divides the sum of squares by the number of corners, not of their coordinates.
  fit.sigma = std::sqrt(0.5) * cv::Mat1d(sigma.reshape(1, 1));
  const cv::Mat1d errors = per_view.reshape(1, 1);
  fit.view_rms.assign(errors.begin(), errors.end());
  return fit;
}

/// k3 takes part where it is seen: elsewhere it would only trade with k2.
CameraFit fit_camera(const Corners& corners, cv::Size size) {
  require_enough(corners.image.size());
  CameraFit fit = fit_camera(corners, size, 0);
  return std::abs(fit.lens.distortion(0, 4)) > 3 * fit.sigma(0, 8)
             ? fit
             : fit_camera(corners, size, cv::CALIB_FIX_K3);
}

int stereo_flags(Lenses lenses, bool with_k3) {
  int flags = cv::CALIB_USE_INTRINSIC_GUESS;
  if (!with_k3) flags |= cv::CALIB_FIX_K3;
  if (lenses == Lenses::kAlike) flags |= cv::CALIB_SAME_FOCAL_LENGTH | cv::CALIB_ZERO_TANGENT_DIST;
  return flags;
}

std::vector<BoardView> side_of(const std::vector<BoardPair>& pairs, BoardView BoardPair::*side) {
  std::vector<BoardView> views;
  views.reserve(pairs.size());
  for (const BoardPair& pair : pairs) views.push_back(pair.*side);
  return views;
}

void require_focal(const std::vector<Estimate>& estimates) {
  const Estimate& focal = estimates.front();
  if (focal.sigma < kPoorestFocal * focal.value) return;
  fail(fmt::format(
      "the views do not determine the focal length ({:.0f} px, standard deviation {:.0f} px); expected "
      "views of the board turned to all sides by 20 deg and more",
      focal.value, focal.sigma));
}

std::vector<SharedCorners> shared_by(const Board& board, const std::vector<BoardPair>& pairs) {
  std::vector<SharedCorners> shared;
  shared.reserve(pairs.size());
  for (const BoardPair& pair : pairs) {
    shared.push_back(shared_corners(pair.left, pair.right));
    if (!shows_enough(board, shared.back().left))
      fail(fmt::format(
          "pair {}: both cameras see {} of the same corners, expected {} or more, not in one line", pair.name,
          shared.back().left.size(), kFewestCorners));
  }
  return shared;
}

void require_whole(const std::vector<bool>& torn, const std::vector<BoardPair>& pairs) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (torn[i]) names.push_back(pairs[i].name);
  if (!names.empty())
    fail(fmt::format(
        "pair {}: left and right image do not belong together (the other {} pairs agree on the cameras' "
        "places); leave out what was not taken at one moment, or take it again",
        fmt::join(names, ", "), pairs.size() - names.size()));
}

/// Says what the pairs lack when a lens comes out as none can be; other faults are the rig's own.
void require_lens(const StereoRig& rig, const std::vector<BoardPair>& pairs) {
  const auto fault = fault_of(rig);
  if (!fault) return;
  const bool left = fault->key.starts_with("left."), right = fault->key.starts_with("right.");
  if (!left && !right) fail(fault->what);
  std::vector<const BoardView*> views;
  for (const BoardPair& pair : pairs) views.push_back(left ? &pair.left : &pair.right);
  const auto unseen = unseen_corners(views, rig.left.width, rig.left.height);
  const std::string lack =
      unseen.empty() ? "take 10 pairs or more, with the board turned to all sides by 20 deg and more"
                     : fmt::format(
                           "none shows the board near the {0} of its image; take more pairs with the board "
                           "there, turned to all sides",
                           fmt::join(unseen, ", "));
  throw UndeterminedLens(fmt::format("calibration: {} pairs do not determine the {} camera's lens: {}",
                                     pairs.size(), left ? "left" : "right", lack));
}

StereoRig fit_rig(const Board& board, const std::vector<SharedCorners>& pairs, Lens left, Lens right,
                  cv::Size size, int flags) {
  Corners in_left, in_right;
  for (const SharedCorners& pair : pairs) add(in_left, board, pair.left), add(in_right, board, pair.right);
  cv::Mat1d turn, place, essential, fundamental;
  try {
    cv::stereoCalibrate(in_left.board, in_left.image, in_right.image, left.matrix, left.distortion,
                        right.matrix, right.distortion, size, turn, place, essential, fundamental, flags,
                        settled());
  } catch (const cv::Exception& e) {
    fail(
        fmt::format("the pairs determine no rig ({}); expected the board tilted differently in each", e.err));
  }
  StereoRig rig;
  rig.name = "calibrated";
  rig.left = left.camera(size.width, size.height);
  rig.right = right.camera(size.width, size.height);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rig.right_from_left.linear()(i, j) = turn(i, j);
    rig.right_from_left.translation()(i) = place(i, 0);
  }
  return rig;
}

// One number of one camera.
RigParameter of_camera(const std::string& name, const std::string& unit, CameraIntrinsics StereoRig::*side,
                       double CameraIntrinsics::*number, double step) {
  return {name, unit, [=](const StereoRig& rig) { return rig.*side.*number; },
          [=](StereoRig& rig, double by) { rig.*side.*number += by; }, step};
}

// The same number of both.
RigParameter of_both(const std::string& name, double CameraIntrinsics::*number, double step) {
  return {name, "px", [=](const StereoRig& rig) { return rig.left.*number; },
          [=](StereoRig& rig, double by) { rig.left.*number += by, rig.right.*number += by; }, step};
}

void add_arrangement(std::vector<RigParameter>& parameters) {
  constexpr std::array kAxes{"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    const std::string axis = kAxes[static_cast<std::size_t>(i)];
    parameters.push_back({"right_from_left.turn_" + axis, "rad",
                          [i](const StereoRig& rig) {
                            const Eigen::AngleAxisd turn(rig.right_from_left.linear());
                            return turn.angle() * turn.axis()(i);
                          },
                          [i](StereoRig& rig, double by) {
                            rig.right_from_left.rotate(Eigen::AngleAxisd(by, Eigen::Vector3d::Unit(i)));
                          },
                          1e-6});
  }
  for (int i = 0; i < 3; ++i) {
    const std::string axis = kAxes[static_cast<std::size_t>(i)];
    parameters.push_back({"right_from_left." + axis, "m",
                          [i](const StereoRig& rig) { return rig.right_from_left.translation()(i); },
                          [i](StereoRig& rig, double by) { rig.right_from_left.translation()(i) += by; },
                          1e-6});
  }
}

/// What the flags of stereo_flags leave free of one camera.
std::vector<RigParameter> camera_parameters(const std::string& at, CameraIntrinsics StereoRig::*side,
                                            Lenses lenses, bool with_k3) {
  using C = CameraIntrinsics;
  std::vector<RigParameter> out;
  const auto free = [&](const char* name, const char* unit, double C::*number, double step) {
    out.push_back(of_camera(at + name, unit, side, number, step));
  };
  const bool alike = lenses == Lenses::kAlike;
  if (!alike) free("fx", "px", &C::fx, 1e-3), free("fy", "px", &C::fy, 1e-3);
  free("cx", "px", &C::cx, 1e-3), free("cy", "px", &C::cy, 1e-3);
  free("k1", "", &C::k1, 1e-6), free("k2", "", &C::k2, 1e-6);
  if (!alike) free("p1", "", &C::p1, 1e-7), free("p2", "", &C::p2, 1e-7);
  if (with_k3) free("k3", "", &C::k3, 1e-6);
  return out;
}

std::vector<RigParameter> rig_parameters(Lenses lenses, bool with_k3) {
  using C = CameraIntrinsics;
  std::vector<RigParameter> out;
  if (lenses == Lenses::kAlike) out = {of_both("fx", &C::fx, 1e-3), of_both("fy", &C::fy, 1e-3)};
  for (const RigParameter& p : camera_parameters("left.", &StereoRig::left, lenses, with_k3))
    out.push_back(p);
  for (const RigParameter& p : camera_parameters("right.", &StereoRig::right, lenses, with_k3))
    out.push_back(p);
  add_arrangement(out);
  return out;
}

}  // namespace

CameraCalibration calibrate_camera(const Board& board, const std::vector<BoardView>& views, int width,
                                   int height) {
  require_usable(board);
  Corners corners;
  for (const BoardView& view : views)
    if (!view.empty()) add(corners, board, view);
  const CameraFit fit = fit_camera(corners, {width, height});
  CameraCalibration out;
  out.camera = fit.lens.camera(width, height);
  out.rms = fit.rms;
  std::vector<SharedCorners> seen;  // by the left camera of a rig whose right one sees nothing
  for (const BoardView& view : views) {
    out.view_rms.push_back(view.empty() ? 0 : fit.view_rms[seen.size()]);
    if (!view.empty()) seen.push_back({view, {}});
  }
  StereoRig rig;
  rig.left = out.camera;
  out.estimates = estimates_of(rig, board, seen, fit_boards(rig, board, seen),
                               camera_parameters("", &StereoRig::left, Lenses::kEach, out.camera.k3 != 0));
  require_focal(out.estimates);
  return out;
}

StereoCalibration calibrate_stereo(const Board& board, const std::vector<BoardPair>& pairs, int width,
                                   int height, Lenses lenses) {
  require_usable(board);
  require_enough(pairs.size());
  const std::vector<SharedCorners> shared = shared_by(board, pairs);
  const CameraCalibration left = calibrate_camera(board, side_of(pairs, &BoardPair::left), width, height),
                          right = calibrate_camera(board, side_of(pairs, &BoardPair::right), width, height);
  require_whole(torn_pairs(board, left.camera, right.camera, shared), pairs);
  const bool with_k3 = left.camera.k3 != 0 || right.camera.k3 != 0;
  StereoCalibration out;
  out.rig = fit_rig(board, shared, Lens(left.camera), Lens(right.camera), {width, height},
                    stereo_flags(lenses, with_k3));
  require_lens(out.rig, pairs);
  const Rectifier rectifier(out.rig);
  const RigFit fit = fit_boards(out.rig, board, shared);
  out.left_rms = left.rms, out.right_rms = right.rms;
  out.rms = std::sqrt(2 * fit.squares() / fit.count());
  out.epipolar = epipolar_error(rectifier, shared);
  out.square = measured_square(rectifier, board, shared);
  out.estimates = estimates_of(out.rig, board, shared, fit, rig_parameters(lenses, with_k3));
  for (std::size_t i = 0; i < pairs.size(); ++i)
    out.pairs.push_back({rms(fit.left[i]), rms(fit.right[i]), epipolar_error(rectifier, {shared[i]}).rms});
  return out;
}

}  // namespace headway::vision
