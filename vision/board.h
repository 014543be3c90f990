// A calibration board and where its corners are seen in an image: a chessboard, or one with ArUco markers in
// its white squares (ChArUco), of which a part is enough.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "hal/frame.h"

namespace headway::vision {

/// Markers in the white squares of a ChArUco board.
struct BoardMarkers {
  std::string dictionary;  ///< OpenCV's name without DICT_, as 4X4_50
  double size = 0;         ///< edge of a marker [m]
};

/// Corners are where four squares meet; 9 x 6 of them belong to a board of 10 x 7 squares. Corner `i` lies in
/// row i / columns, column i % columns; the board's frame has its origin in corner 0, x along the rows, y
/// down the columns, z into the board [m].
struct Board {
  int columns = 0, rows = 0;
  double square = 0;  ///< edge of a square [m]
  std::optional<BoardMarkers> markers;

  int corners() const { return columns * rows; }
  Eigen::Vector3d corner(int i) const {
    const int row = i / columns, column = i % columns;
    return {square * column, square * row, 0};
  }
};

/// The names that BoardMarkers::dictionary may have.
const std::vector<std::string>& marker_dictionaries();

/// Throws InputError `board: key: what` unless it has 3 to 40 corners each way, squares of 1 mm to 1 m, and
/// markers of a known dictionary that fit into the squares and suffice for them; or no markers, and not as
/// many corners one way as the other.
void require_usable(const Board& board);

/// Corners seen in one image, in rising order: pixel `pixels[k]` shows corner `ids[k]`.
struct BoardView {
  std::vector<int> ids;
  std::vector<Eigen::Vector2d> pixels;  ///< [px], (0, 0) is the centre of the upper left pixel

  std::size_t size() const { return ids.size(); }
  bool empty() const { return ids.empty(); }
};

/// Finds the board's corners to sub-pixel precision. A chessboard is seen whole or not at all; of a ChArUco
/// board enough corners for a pose. An empty view: there is no such board in the image.
/// Corner 0 is the same in every image if the board's sides or colours tell which it is (one side odd, the
/// other even; or markers); otherwise it is the one that lies to the upper left of the image.
BoardView find_board(const Board& board, const hal::GrayImage& image);

inline constexpr std::size_t kFewestCorners = 6;  ///< of a view, for a pose

/// Whether a view shows that many corners or more, not all in one line: enough for a pose.
bool shows_enough(const Board& board, const BoardView& view);

/// The corners that both views show, in each.
struct SharedCorners {
  BoardView left, right;
};
SharedCorners shared_corners(const BoardView& left, const BoardView& right);

}  // namespace headway::vision
