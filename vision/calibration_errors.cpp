#include "vision/calibration_errors.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "vision/median.h"

namespace headway::vision {

namespace {

constexpr double kRobustSigma = 1.4826;  // of a normal distribution over its median distance from the median
constexpr double kFarOut = 4, kNoticeable = 0.25;

/// Triangulated corners of one pair by their number, in the rectified left camera's frame [m].
std::map<int, Eigen::Vector3d> triangulated(const Rectifier& rectifier, const SharedCorners& pair) {
  std::map<int, Eigen::Vector3d> points;
  for (std::size_t k = 0; k < pair.left.size(); ++k) {
    const Eigen::Vector2d l = rectifier.rectified_left(pair.left.pixels[k]),
                          r = rectifier.rectified_right(pair.right.pixels[k]);
    const double z = rectifier.rig().depth(l.x() - r.x());
    if (z > 0) points.emplace(pair.left.ids[k], rectifier.rig().camera.point(l.x(), l.y(), z));
  }
  return points;
}

}  // namespace

EpipolarError epipolar_error(const Rectifier& rectifier, const std::vector<SharedCorners>& pairs) {
  EpipolarError error;
  double corners = 0;
  for (const SharedCorners& pair : pairs) {
    for (std::size_t k = 0; k < pair.left.size(); ++k) {
      const double rows = std::abs(rectifier.rectified_left(pair.left.pixels[k]).y() -
                                   rectifier.rectified_right(pair.right.pixels[k]).y());
      error.mean += rows, error.rms += rows * rows, corners += 1;
      error.largest = std::max(error.largest, rows);
    }
  }
  if (corners > 0) error.mean /= corners, error.rms = std::sqrt(error.rms / corners);
  return error;
}

SquareLength measured_square(const Rectifier& rectifier, const Board& board,
                             const std::vector<SharedCorners>& pairs) {
  double n = 0, sum = 0, squares = 0;
  for (const SharedCorners& pair : pairs) {
    const auto points = triangulated(rectifier, pair);
    for (const auto& [id, point] : points) {
      for (const int next : {id % board.columns + 1 < board.columns ? id + 1 : -1, id + board.columns}) {
        const auto other = points.find(next);
        if (other == points.end()) continue;
        const double length = (other->second - point).norm() / board.square;
        n += 1, sum += length, squares += length * length;
      }
    }
  }
  if (n < 2) return {};
  return {sum / n, std::sqrt(std::max(0.0, (squares - sum * sum / n) / (n - 1)))};
}

std::vector<bool> standing_out(const std::vector<double>& errors) {
  const double middle = median(errors);
  std::vector<double> distances;
  distances.reserve(errors.size());
  for (const double e : errors) distances.push_back(std::abs(e - middle));
  const double limit = middle + std::max(kFarOut * kRobustSigma * median(distances), kNoticeable * middle);
  std::vector<bool> out(errors.size());
  std::transform(errors.begin(), errors.end(), out.begin(), [&](double e) { return e > limit; });
  return out;
}

}  // namespace headway::vision
