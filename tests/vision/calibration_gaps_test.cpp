#include "vision/calibration_gaps.h"

#include <Eigen/Geometry>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/calibration.h"

namespace headway::vision {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Board kBoard{9, 6, 0.03, {}};

CameraIntrinsics camera() {
  CameraIntrinsics c;
  c.width = 640, c.height = 480, c.fx = c.fy = 530, c.cx = 320, c.cy = 240;
  c.k1 = -0.28, c.k2 = 0.1;
  return c;
}

Isometry3d right_from_left() {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() << -0.1, 0, 0;
  return pose;
}

/// A board that is held up in different ways around one place before the left camera.
class HeldUp {
 public:
  HeldUp(std::uint32_t seed, Vector3d place) : random_(seed), place_(std::move(place)) {}

  SharedCorners next() {
    const auto between = [&](double a, double b) {
      return std::uniform_real_distribution<double>(a, b)(random_);
    };
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = place_ + 0.03 * Vector3d(between(-1, 1), between(-1, 1), between(-2, 2));
    pose.rotate(AngleAxisd(between(-0.4, 0.4), Vector3d::UnitX()) *
                AngleAxisd(between(-0.4, 0.4), Vector3d::UnitY()));
    pose.translate(-0.5 * kBoard.corner(kBoard.corners() - 1));
    return {seen(pose), seen(right_from_left() * pose)};
  }

 private:
  BoardView seen(const Isometry3d& camera_from_board) {
    std::normal_distribution<double> noise(0, 0.3);
    BoardView view;
    for (int i = 0; i < kBoard.corners(); ++i) {
      view.ids.push_back(i);
      view.pixels.push_back(camera().project(camera_from_board * kBoard.corner(i)) +
                            Eigen::Vector2d(noise(random_), noise(random_)));
    }
    return view;
  }

  std::mt19937 random_;
  Vector3d place_;
};

TEST(CalibrationGaps, AreTheCornersOfTheImageWhereNothingWasSeen) {
  const BoardView left_edge{{0, 1}, {{10, 12}, {20, 470}}}, middle{{0}, {{320, 240}}},
      corner{{0}, {{630, 5}}};
  EXPECT_THAT(unseen_corners({&middle}, 640, 480),
              ElementsAre("upper left", "upper right", "lower left", "lower right"));
  EXPECT_THAT(unseen_corners({&left_edge, &middle}, 640, 480), ElementsAre("upper right", "lower right"));
  EXPECT_THAT(unseen_corners({&left_edge, &corner}, 640, 480), ElementsAre("lower right"));
}

TEST(CalibrationGaps, ExplainEveryLensThatAOneSidedSetLeavesOpen) {
  int open = 0;
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    HeldUp right_side(seed, {0.16, 0, 0.75});
    std::vector<BoardPair> pairs;
    for (int i = 0; i < 4; ++i) {
      const SharedCorners both = right_side.next();
      pairs.push_back({both.left, both.right});
    }
    try {
      calibrate_stereo(kBoard, pairs, 640, 480);
    } catch (const UndeterminedLens& fault) {
      ++open;
      EXPECT_THAT(fault.what(), HasSubstr("camera's lens: none shows the board near the upper left"));
    } catch (const InputError& other) {
      EXPECT_THAT(other.what(), HasSubstr("do not determine the focal length"));
    }
  }
  EXPECT_GE(open, 1) << "else this shows nothing";
}

TEST(CalibrationGaps, TearNoPairOfASoundSetAndEveryOneTakenTwoAtATime) {
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    HeldUp board(seed, {0.05, 0, 0.7});
    std::vector<SharedCorners> pairs;
    for (int i = 0; i < 8; ++i) pairs.push_back(board.next());
    EXPECT_EQ(torn_pairs(kBoard, camera(), camera(), pairs), std::vector<bool>(8, false));
    HeldUp elsewhere(seed + 100, {-0.02, 0.06, 0.8});
    std::vector<bool> torn(8, false);
    for (const std::size_t i : {seed % 3, 3 + seed % 5})
      pairs[i].right = elsewhere.next().right, torn[i] = true;
    EXPECT_EQ(torn_pairs(kBoard, camera(), camera(), pairs), torn) << "seed " << seed;
  }
  EXPECT_THAT(torn_pairs(kBoard, camera(), camera(), {}), IsEmpty());
}

TEST(CalibrationGaps, OfAPairWithTooFewSharedCornersAreCounted) {
  HeldUp board(1, {0.05, 0, 0.7});
  std::vector<BoardPair> pairs;
  for (int i = 0; i < 5; ++i) {
    const SharedCorners both = board.next();
    pairs.push_back({both.left, both.right, "no. " + std::to_string(i)});
  }
  for (BoardView* view : {&pairs[3].left, &pairs[3].right}) view->ids.resize(5), view->pixels.resize(5);
  try {
    calibrate_stereo(kBoard, pairs, 640, 480);
    FAIL() << "was taken";
  } catch (const InputError& fault) {
    EXPECT_THAT(fault.what(),
                HasSubstr("pair no. 3: both cameras see 5 of the same corners, expected 6 or more"));
  }
}

}  // namespace
}  // namespace headway::vision
