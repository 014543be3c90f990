#include "vision/calibration_gaps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/board_pose.h"

namespace headway::vision {

namespace {

using Eigen::Isometry3d;

constexpr double kOuter = 0.25;                   // share of an image's side that is near its end
constexpr double kTorn = 0.03, kUnlikeRest = 10;  // of the image's width; of the median pair's error

double upper_median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Where each camera by itself sees the board of one pair.
struct Stand {
  Isometry3d left_from_board, right_from_left;
};

std::vector<double> errors_under(const Isometry3d& right_from_left, const Board& board,
                                 const CameraIntrinsics& right, const std::vector<Stand>& stands,
                                 const std::vector<SharedCorners>& pairs) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::VectorXd off =
        reprojection_residuals(right, right_from_left * stands[i].left_from_board, board, pairs[i].right);
    const double rms = std::sqrt(2 * off.squaredNorm() / static_cast<double>(off.size()));
    errors.push_back(std::isfinite(rms) ? rms : std::numeric_limits<double>::infinity());
  }
  return errors;
}

}  // namespace

std::vector<std::string> unseen_corners(const std::vector<const BoardView*>& views, int width, int height) {
  std::vector<std::string> unseen;
  for (const bool lower : {false, true}) {
    for (const bool right : {false, true}) {
      const auto near = [&](const Eigen::Vector2d& p) {
        const double x = right ? width - 1 - p.x() : p.x(), y = lower ? height - 1 - p.y() : p.y();
        return x < kOuter * width && y < kOuter * height;
      };
      const bool seen = std::any_of(views.begin(), views.end(), [&](const BoardView* view) {
        return std::any_of(view->pixels.begin(), view->pixels.end(), near);
      });
      if (!seen) unseen.push_back(std::string(lower ? "lower " : "upper ") + (right ? "right" : "left"));
    }
  }
  return unseen;
}

std::vector<bool> torn_pairs(const Board& board, const CameraIntrinsics& left, const CameraIntrinsics& right,
                             const std::vector<SharedCorners>& pairs) {
  std::vector<Stand> stands;
  for (const SharedCorners& pair : pairs) {
    const Isometry3d left_from_board = camera_from_board(left, board, pair.left);
    stands.push_back(
        {left_from_board, camera_from_board(right, board, pair.right) * left_from_board.inverse()});
  }
  std::vector<double> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Stand& stand : stands) {
    std::vector<double> errors = errors_under(stand.right_from_left, board, right, stands, pairs);
    if (const double usual = upper_median(errors); usual < least) least = usual, best = std::move(errors);
  }
  std::vector<bool> torn(pairs.size(), false);
  for (std::size_t i = 0; i < best.size(); ++i)
    torn[i] = best[i] > kTorn * right.width && best[i] > kUnlikeRest * least;
  return torn;
}

}  // namespace headway::vision
