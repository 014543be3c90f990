#include "vision/board.h"

#include <Eigen/Geometry>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "random_rig.h"
#include "rendered_board.h"

namespace headway::vision {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

CameraIntrinsics camera() {
  CameraIntrinsics c;
  c.width = 320, c.height = 240, c.fx = c.fy = 350, c.cx = 161, c.cy = 118;
  return c;
}

Board chessboard(int columns = 9, int rows = 6) { return {columns, rows, 0.025, {}}; }
Board charuco() { return {8, 6, 0.03, BoardMarkers{"4X4_100", 0.022}}; }

/// Facing the camera, then turned by these angles [rad], its middle at `place` [m].
Isometry3d pose_of(const Board& board, const Vector3d& place, double across, double down, double roll) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = place;
  pose.rotate(AngleAxisd(roll, Vector3d::UnitZ()) * AngleAxisd(across, Vector3d::UnitY()) *
              AngleAxisd(down, Vector3d::UnitX()));
  return pose * Eigen::Translation3d(-0.5 * (board.corner(0) + board.corner(board.corners() - 1)));
}

hal::GrayImage image_of(const Board& board, const Isometry3d& pose) {
  return test::BoardRenderer(camera()).render(test::BoardPrint(board), pose);
}

/// How far seen corners are from where they truly are [px].
struct Distance {
  double rms = 0, worst = 0;
};
Distance distance(const Board& board, const Isometry3d& pose, const BoardView& view) {
  Distance out;
  for (std::size_t k = 0; k < view.size(); ++k) {
    const double away = (view.pixels[k] - camera().project(pose * board.corner(view.ids[k]))).norm();
    out.worst = std::max(out.worst, away);
    out.rms += away * away / static_cast<double>(view.size());
  }
  out.rms = std::sqrt(out.rms);
  return out;
}

RC_GTEST_PROP(Board, FindsEveryCornerOfAChessboardMuchFinerThanAPixel, ()) {
  const Board board = chessboard();
  const Isometry3d pose =
      pose_of(board, {test::between(-0.02, 0.02), test::between(-0.02, 0.02), test::between(0.43, 0.5)},
              test::between(-0.35, 0.35), test::between(-0.35, 0.35), test::between(-0.4, 0.4));
  const BoardView view = find_board(board, image_of(board, pose));
  RC_ASSERT(view.size() == 54U);
  const Distance away = distance(board, pose, view);
  RC_ASSERT(away.rms < 0.15);
  RC_ASSERT(away.worst < 0.4);
}

TEST(Board, KnowsWhichWayRoundAChessboardIsByItsColours) {
  const Board board = chessboard();
  for (const double roll : {0.0, 1.2, 2.5, M_PI, -1.9}) {
    const Isometry3d pose = pose_of(board, {0, 0, 0.45}, 0.2, 0.1, roll);
    const BoardView view = find_board(board, image_of(board, pose));
    ASSERT_EQ(view.size(), 54U) << roll;
    EXPECT_LT(distance(board, pose, view).worst, 0.3) << "turned by " << roll;
  }
}

TEST(Board, TakesTheUpperLeftCornerFirstWhereColoursDoNotTell) {
  const Board board = chessboard(7, 5);
  for (const double roll : {0.2, -0.3, 0.2 + M_PI}) {
    const BoardView view = find_board(board, image_of(board, pose_of(board, {0, 0, 0.4}, 0, 0, roll)));
    ASSERT_EQ(view.size(), 35U);
    EXPECT_LT(view.pixels.front().x() + view.pixels.front().y(),
              view.pixels.back().x() + view.pixels.back().y());
  }
}

TEST(Board, FindsTheVisiblePartOfACharucoBoardWithTheRightNumbers) {
  const Board board = charuco();
  const Isometry3d whole = pose_of(board, {0, 0, 0.4}, 0.3, -0.2, 0.4);
  const BoardView all = find_board(board, image_of(board, whole));
  EXPECT_GE(all.size(), 42U);
  EXPECT_LT(distance(board, whole, all).rms, 0.15);
  const Isometry3d cut = pose_of(board, {0.14, 0.05, 0.35}, 0.3, -0.2, M_PI / 2);
  const BoardView part = find_board(board, image_of(board, cut));
  EXPECT_GE(part.size(), 8U);
  EXPECT_LT(part.size(), 48U);
  EXPECT_LT(distance(board, cut, part).rms, 0.15);
  EXPECT_TRUE(std::is_sorted(part.ids.begin(), part.ids.end()));
}

TEST(Board, IsNotSeenWhereItIsNot) {
  std::mt19937 random(3);
  hal::GrayImage noise{160, 120, {}};
  for (int i = 0; i < 160 * 120; ++i) noise.pixels.push_back(static_cast<std::uint8_t>(random() % 256));
  hal::GrayImage grey{160, 120, std::vector<std::uint8_t>(160 * 120, 128)};
  const hal::GrayImage other = image_of(chessboard(7, 5), pose_of(chessboard(7, 5), {0, 0, 0.4}, 0, 0, 0));
  for (const Board& board : {chessboard(), charuco()}) {
    EXPECT_TRUE(find_board(board, noise).empty());
    EXPECT_TRUE(find_board(board, grey).empty());
    EXPECT_TRUE(find_board(board, other).empty());
  }
}

TEST(Board, ThatCannotBeIsRefused) {
  const auto message = [](const Board& board) -> std::string {
    try {
      require_usable(board);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  using testing::HasSubstr;
  EXPECT_EQ(message(chessboard()), "");
  EXPECT_EQ(message(charuco()), "");
  EXPECT_THAT(message(chessboard(2, 6)), HasSubstr("2 x 6 corners"));
  EXPECT_THAT(message(chessboard(6, 6)), HasSubstr("6 x 6 corners: which one is the first"));
  EXPECT_EQ(message({6, 6, 0.03, BoardMarkers{"4X4_100", 0.02}}), "") << "its markers tell";
  EXPECT_THAT(message({9, 6, 25, {}}), HasSubstr("square: 25 m"));
  EXPECT_THAT(message({9, 6, 0.03, BoardMarkers{"4X4_100", 0.04}}), HasSubstr("marker: 0.04 m"));
  EXPECT_THAT(message({9, 6, 0.03, BoardMarkers{"DICT_9", 0.02}}),
              HasSubstr("'DICT_9', expected one of 4X4_50"));
  EXPECT_THAT(message({12, 9, 0.03, BoardMarkers{"4X4_50", 0.02}}),
              HasSubstr("has 50 markers, expected at least 65"));
}

TEST(SharedCorners, AreThoseThatBothCamerasSee) {
  const BoardView left{{1, 3, 4, 8}, {{1, 0}, {3, 0}, {4, 0}, {8, 0}}},
      right{{0, 3, 8, 9}, {{0, 1}, {3, 1}, {8, 1}, {9, 1}}};
  const SharedCorners shared = shared_corners(left, right);
  EXPECT_THAT(shared.left.ids, testing::ElementsAre(3, 8));
  EXPECT_THAT(shared.right.ids, testing::ElementsAre(3, 8));
  EXPECT_EQ(shared.left.pixels[1], Eigen::Vector2d(8, 0));
  EXPECT_EQ(shared.right.pixels[1], Eigen::Vector2d(8, 1));
}

TEST(ShowsEnough, NeedsSixCornersOffOneLine) {
  const Board board = chessboard();
  const auto shows = [&](std::vector<int> ids) {
    BoardView view{ids, {}};
    view.pixels.resize(ids.size());
    return shows_enough(board, view);
  };
  EXPECT_TRUE(shows({0, 1, 2, 3, 4, 9}));
  EXPECT_FALSE(shows({0, 1, 2, 3, 9}));
  EXPECT_FALSE(shows({0, 1, 2, 3, 4, 5, 6}));
  EXPECT_FALSE(shows({0, 10, 20, 30, 40, 50}));
}

}  // namespace
}  // namespace headway::vision
