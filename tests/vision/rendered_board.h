// Images of a calibration board whose pose is known.
#pragma once

#include <cmath>
#include <vector>

#include <opencv2/aruco/charuco.hpp>

#include "hal/frame.h"
#include "vision/board.h"
#include "vision/rig.h"

namespace headway::vision::test {

/// What is printed on the board's plane; `x`, `y` in the board's frame [m]. A white margin, then grey.
class BoardPrint {
 public:
  explicit BoardPrint(const Board& board) : board_(board) {
    if (!board.markers) return;
    const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_100);
    const auto charuco =
        cv::aruco::CharucoBoard::create(board.columns + 1, board.rows + 1, static_cast<float>(board.square),
                                        static_cast<float>(board.markers->size), dictionary);
    charuco->draw({kPxPerSquare * (board.columns + 1), kPxPerSquare * (board.rows + 1)}, picture_);
  }

  double grey(double x, double y) const {
    const double across = x / board_.square + 1, down = y / board_.square + 1;  // from the board's edge
    const double margin = 0.7, beyond_x = std::max(-across, across - board_.columns - 1),
                 beyond_y = std::max(-down, down - board_.rows - 1);
    if (std::max(beyond_x, beyond_y) > margin) return 110;
    if (std::max(beyond_x, beyond_y) > 0) return 225;
    if (!picture_.empty()) {
      const auto at = [](double squares, int size) {
        return std::clamp(static_cast<int>(squares * kPxPerSquare), 0, size - 1);
      };
      return picture_.at<std::uint8_t>(at(down, picture_.rows), at(across, picture_.cols)) > 128 ? 225 : 25;
    }
    return (static_cast<int>(across) + static_cast<int>(down)) % 2 != 0 ? 225 : 25;
  }

 private:
  static constexpr int kPxPerSquare = 60;
  Board board_;
  cv::Mat1b picture_;
};

/// Renders for one camera; every pixel averages rays over a square of 1.5 px, as a lens blurs them. No two of
/// them lie in one row or column, so that upright edges do not step.
class BoardRenderer {
 public:
  explicit BoardRenderer(const CameraIntrinsics& camera) : camera_(camera) {}

  hal::GrayImage render(const BoardPrint& print, const Eigen::Isometry3d& camera_from_board) const {
    const Eigen::Isometry3d board_from_camera = camera_from_board.inverse();
    const Eigen::Vector3d from = board_from_camera.translation();
    hal::GrayImage image{camera_.width, camera_.height, {}};
    for (int v = 0; v < camera_.height; ++v) {
      for (int u = 0; u < camera_.width; ++u) {
        double sum = 0;
        for (int i = 0; i < kRays; ++i) {
          const Eigen::Vector3d along =
              board_from_camera.linear() * ray(u + offset(i), v + offset(i * kStride % kRays));
          const double reach = -from.z() / along.z();
          sum += reach > 0 ? print.grey(from.x() + reach * along.x(), from.y() + reach * along.y()) : 110;
        }
        image.pixels.push_back(static_cast<std::uint8_t>(std::lround(sum / kRays)));
      }
    }
    return image;
  }

 private:
  static constexpr int kRays = 11, kStride = 3;
  static double offset(int i) { return 1.5 * ((i + 0.5) / kRays - 0.5); }
  /// Without distortion, which these images do not need.
  Eigen::Vector3d ray(double u, double v) const {
    return {(u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy, 1};
  }
  CameraIntrinsics camera_;
};

}  // namespace headway::vision::test
