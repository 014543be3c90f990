#include "vision/board.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "hal/error.h"
#include "vision/cv_image.h"

namespace headway::vision {

namespace {

using Eigen::Vector2d;

constexpr double kRefinementWindow = 5;  // [px] each way from a corner, if the squares are not smaller

cv::TermCriteria refined() { return {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 1e-3}; }

struct Dictionary {
  std::string name;
  int number;
};

const std::vector<Dictionary>& dictionaries() {
  static const std::vector<Dictionary> all = [] {
    std::vector<Dictionary> list;
    int number = cv::aruco::DICT_4X4_50;
    for (const int bits : {4, 5, 6, 7}) {
      for (const int count : {50, 100, 250, 1000})
        list.push_back({fmt::format("{}X{}_{}", bits, bits, count), number++});
    }
    list.push_back({"ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL});
    for (const char* name : {"APRILTAG_16h5", "APRILTAG_25h9", "APRILTAG_36h10", "APRILTAG_36h11"})
      list.push_back({name, ++number});
    return list;
  }();
  return all;
}

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const BoardMarkers& markers) {
  for (const Dictionary& d : dictionaries())
    if (d.name == markers.dictionary) return cv::aruco::getPredefinedDictionary(d.number);
  throw InputError(fmt::format("board: dictionary: '{}', expected one of {}", markers.dictionary,
                               fmt::join(marker_dictionaries(), ", ")));
}

/// Smallest distance of neighbours in the view [px].
double spacing(const Board& board, const BoardView& view) {
  double least = 1e9;
  for (std::size_t k = 0; k + 1 < view.size(); ++k) {
    for (std::size_t n = k + 1; n < view.size() && view.ids[n] <= view.ids[k] + board.columns; ++n) {
      const int step = view.ids[n] - view.ids[k];
      const bool beside = step == 1 && view.ids[n] % board.columns != 0;
      if (beside || step == board.columns) least = std::min(least, (view.pixels[n] - view.pixels[k]).norm());
    }
  }
  return least;
}

/// Moves every corner to where the edges around it cross. The window reaches neither the neighbouring corners
/// nor the markers, whose edges would draw it away.
void refine(const Board& board, const cv::Mat& image, BoardView& view) {
  const double clear = board.markers ? (board.square - board.markers->size) / (2 * board.square) : 0.5;
  const int window = static_cast<int>(std::clamp(clear * spacing(board, view), 2.0, kRefinementWindow));
  std::vector<cv::Point2f> corners;
  for (const Vector2d& p : view.pixels)
    corners.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  cv::cornerSubPix(image, corners, {window, window}, {-1, -1}, refined());
  for (std::size_t k = 0; k < corners.size(); ++k) view.pixels[k] = {corners[k].x, corners[k].y};
}

/// The mean grey of the square between four corners.
double grey_of_square(const cv::Mat& image, const std::vector<cv::Point2f>& c, std::size_t at,
                      std::size_t columns) {
  const cv::Point2f middle = 0.25F * (c[at] + c[at + 1] + c[at + columns] + c[at + columns + 1]);
  cv::Mat patch;
  cv::getRectSubPix(image, {3, 3}, middle, patch);
  return cv::mean(patch)[0];
}

/// Half a turn maps a chessboard onto itself; which end is corner 0 must not depend on the detector's mood.
bool starts_at_the_wrong_end(const Board& board, const cv::Mat& image, const std::vector<cv::Point2f>& c) {
  if ((board.columns + board.rows) % 2 != 0) {
    const auto columns = static_cast<std::size_t>(board.columns);
    return grey_of_square(image, c, 0, columns) > grey_of_square(image, c, c.size() - columns - 2, columns);
  }
  const cv::Point2f across = c.back() - c.front();
  return across.x + across.y < 0;
}

BoardView find_chessboard(const Board& board, const cv::Mat& image) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(image, {board.columns, board.rows}, corners)) return {};
  if (starts_at_the_wrong_end(board, image, corners)) std::reverse(corners.begin(), corners.end());
  BoardView view;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    view.ids.push_back(static_cast<int>(i));
    view.pixels.emplace_back(corners[i].x, corners[i].y);
  }
  refine(board, image, view);
  return view;
}

cv::Ptr<cv::aruco::CharucoBoard> charuco_of(const Board& board) {
  return cv::aruco::CharucoBoard::create(board.columns + 1, board.rows + 1, static_cast<float>(board.square),
                                         static_cast<float>(board.markers->size),
                                         dictionary_of(*board.markers));
}

BoardView find_charuco(const Board& board, const cv::Mat& image) {
  const cv::Ptr<cv::aruco::CharucoBoard> charuco = charuco_of(board);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids, ids;
  std::vector<cv::Point2f> corners;
  cv::aruco::detectMarkers(image, charuco->dictionary, markers, marker_ids);
  if (marker_ids.empty()) return {};
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, image, charuco, corners, ids);
  BoardView view;
  view.ids = ids;  // counted in rows from the upper left, as here
  // OpenCV 4.6 returns these half a pixel too far right and down.
  for (const cv::Point2f& corner : corners) view.pixels.emplace_back(corner.x - 0.5, corner.y - 0.5);
  if (!shows_enough(board, view)) return {};
  refine(board, image, view);
  return view;
}

}  // namespace

const std::vector<std::string>& marker_dictionaries() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Dictionary& d : dictionaries()) list.push_back(d.name);
    return list;
  }();
  return names;
}

void require_usable(const Board& board) {
  const auto fail = [](const std::string& what) { throw InputError("board: " + what); };
  for (const int n : {board.columns, board.rows})
    if (n < 3 || n > 40)
      fail(fmt::format("{} x {} corners, expected 3 to 40 each way", board.columns, board.rows));
  if (!(board.square >= 0.001 && board.square <= 1))
    fail(fmt::format("square: {} m, expected 0.001 to 1 m", board.square));
  if (!board.markers && board.columns == board.rows)
    fail(
        fmt::format("{0} x {0} corners: which one is the first cannot be told after a quarter turn, expected "
                    "more one way than the other, or markers",
                    board.columns));
  if (!board.markers) return;
  const int markers = (board.columns + 1) * (board.rows + 1) / 2,
            known = dictionary_of(*board.markers)->bytesList.rows;
  if (!(board.markers->size > 0 && board.markers->size < board.square))
    fail(fmt::format("marker: {} m, expected more than 0 and less than the square ({} m)",
                     board.markers->size, board.square));
  if (markers > known)
    fail(fmt::format("dictionary: {} has {} markers, expected at least {} for {} x {} squares",
                     board.markers->dictionary, known, markers, board.columns + 1, board.rows + 1));
}

BoardView find_board(const Board& board, const hal::GrayImage& image) {
  require_usable(board);
  if (!complete(image)) throw InputError("board: the image is incomplete");
  const cv::Mat grey = as_mat(image);
  return board.markers ? find_charuco(board, grey) : find_chessboard(board, grey);
}

bool shows_enough(const Board& board, const BoardView& view) {
  if (view.size() < kFewestCorners) return false;
  const Eigen::Vector3d first = board.corner(view.ids.front()), along = board.corner(view.ids.back()) - first;
  return std::any_of(view.ids.begin(), view.ids.end(), [&](int id) {
    return along.cross(board.corner(id) - first).norm() > 1e-3 * board.square * board.square;
  });
}

SharedCorners shared_corners(const BoardView& left, const BoardView& right) {
  SharedCorners shared;
  for (std::size_t l = 0, r = 0; l < left.size() && r < right.size();) {
    if (left.ids[l] == right.ids[r]) {
      shared.left.ids.push_back(left.ids[l]), shared.left.pixels.push_back(left.pixels[l]);
      shared.right.ids.push_back(right.ids[r]), shared.right.pixels.push_back(right.pixels[r]);
    }
    const bool left_behind = left.ids[l] <= right.ids[r], right_behind = right.ids[r] <= left.ids[l];
    l += left_behind ? 1 : 0, r += right_behind ? 1 : 0;
  }
  return shared;
}

}  // namespace headway::vision
