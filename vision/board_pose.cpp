#include "vision/board_pose.h"

#include <limits>
#include <vector>

#include <opencv2/calib3d.hpp>

#include "hal/error.h"
#include "vision/least_squares.h"

namespace headway::vision {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kFlattestRay = 0.1;  // z of a unit ray; flatter ones do not meet the plane usefully

[[noreturn]] void fail() {
  throw InputError("board: its corners in the image fit no pose before the camera; expected a flat board");
}

/// Good enough to start from: OpenCV's pose from where the rays of the pixels meet the plane z = 1.
Isometry3d first_guess(const CameraIntrinsics& camera, const Board& board, const BoardView& view) {
  std::vector<cv::Point3d> corners;
  std::vector<cv::Point2d> places;
  for (std::size_t k = 0; k < view.size(); ++k) {
    const auto ray = camera.unproject(view.pixels[k]);
    if (!ray || ray->z() < kFlattestRay) continue;
    const Vector3d corner = board.corner(view.ids[k]);
    corners.emplace_back(corner.x(), corner.y(), corner.z());
    places.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  if (corners.size() < 4) fail();
  cv::Vec3d turn, place;
  try {
    if (!cv::solvePnP(corners, places, cv::Matx33d::eye(), cv::noArray(), turn, place)) fail();
  } catch (const cv::Exception&) {
    fail();
  }
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() << place[0], place[1], place[2];
  return moved(pose, (Vector6d() << turn[0], turn[1], turn[2], 0, 0, 0).finished());
}

}  // namespace

Isometry3d moved(const Isometry3d& pose, const Vector6d& motion) {
  const Vector3d turn = motion.head<3>();
  Isometry3d by = Isometry3d::Identity();
  by.translation() = motion.tail<3>();
  if (const double angle = turn.norm(); angle > 0)
    by.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  return pose * by;
}

VectorXd reprojection_residuals(const CameraIntrinsics& camera, const Isometry3d& camera_from_board,
                                const Board& board, const BoardView& view) {
  VectorXd out(2 * static_cast<Eigen::Index>(view.size()));
  for (std::size_t k = 0; k < view.size(); ++k) {
    const Vector3d point = camera_from_board * board.corner(view.ids[k]);
    const Vector2d seen =
        point.z() > 0 ? camera.project(point) : Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    out.segment<2>(2 * static_cast<Eigen::Index>(k)) = view.pixels[k] - seen;
  }
  return out;
}

Isometry3d camera_from_board(const CameraIntrinsics& camera, const Board& board, const BoardView& view) {
  const Isometry3d guess = first_guess(camera, board, view);
  const auto residuals = [&](const VectorXd& x) {
    return reprojection_residuals(camera, moved(guess, x), board, view);
  };
  const VectorXd steps = (Vector6d() << 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5).finished();
  return moved(guess, minimise(residuals, VectorXd::Zero(6), steps).x);
}

}  // namespace headway::vision
