#include "vision/calibration.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/source_dir/source_dir.h"
#include "vision/image_files.h"
#include "vision/rig_files.h"

namespace headway::vision {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kNoise = 0.2;  // [px]
const Board kBoard{9, 6, 0.03, {}};

/// The bottom pair of HRP-2, without k3.
StereoRig true_rig() {
  static const StereoRig rig = read_rig(source_dir() / "config/hrp2/rigs/bottom.yaml");
  return rig;
}

BoardView seen(const CameraIntrinsics& camera, const Isometry3d& camera_from_board, double noise,
               std::mt19937& random) {
  std::normal_distribution<double> error(0, noise);
  BoardView view;
  for (int i = 0; i < kBoard.corners(); ++i) {
    const Vector2d pixel = camera.project(camera_from_board * kBoard.corner(i));
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > camera.width - 1 || pixel.y() > camera.height - 1)
      return {};
    view.ids.push_back(i);
    view.pixels.emplace_back(pixel.x() + error(random), pixel.y() + error(random));
  }
  return view;
}

/// A board held up in many ways, wholly seen by both cameras.
std::vector<BoardPair> simulated(std::uint32_t seed, std::size_t count = 14, double noise = kNoise,
                                 double tilt = 0.6) {
  std::mt19937 random(seed);
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  std::vector<BoardPair> pairs;
  while (pairs.size() < count) {
    Isometry3d pose = Isometry3d::Identity();
    const double z = between(0.7, 1.2);
    pose.translation() << 0.07 + between(-0.25, 0.25) * z, between(-0.4, 0.4) * z, z;
    pose.rotate(AngleAxisd(between(-0.3, 0.3), Vector3d::UnitZ()) *
                AngleAxisd(between(-tilt, tilt), Vector3d::UnitY()) *
                AngleAxisd(between(-tilt, tilt), Vector3d::UnitX()));
    pose.translate(-0.5 * kBoard.corner(kBoard.corners() - 1));
    const StereoRig rig = true_rig();
    const BoardPair pair{seen(rig.left, pose, noise, random),
                         seen(rig.right, rig.right_from_left * pose, noise, random)};
    if (!pair.left.empty() && !pair.right.empty()) pairs.push_back(pair);
  }
  return pairs;
}

StereoCalibration calibrated(const std::vector<BoardPair>& pairs, Lenses lenses = Lenses::kEach) {
  const StereoRig rig = true_rig();
  return calibrate_stereo(kBoard, pairs, rig.left.width, rig.left.height, lenses);
}

/// The true value of an estimate.
double truth(const std::string& name) {
  const StereoRig rig = true_rig();
  const AngleAxisd turn(rig.right_from_left.linear());
  for (const auto& [side, c] :
       {std::pair<std::string, CameraIntrinsics>{"left.", rig.left}, {"right.", rig.right}}) {
    const std::vector<std::pair<std::string, double>> all{{"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx},
                                                          {"cy", c.cy}, {"k1", c.k1}, {"k2", c.k2},
                                                          {"p1", c.p1}, {"p2", c.p2}, {"k3", c.k3}};
    for (const auto& [key, value] : all)
      if (name == side + key) return value;
  }
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    if (name == "right_from_left.turn_" + axis) return turn.angle() * turn.axis()(i);
    if (name == "right_from_left." + axis) return rig.right_from_left.translation()(i);
  }
  throw std::logic_error("no truth for " + name);
}

std::string message_of(const std::vector<BoardPair>& pairs) {
  try {
    calibrated(pairs);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(StereoCalibration, FindsTheTruthWithinItsStandardDeviations) {
  double squares = 0, count = 0;
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const StereoCalibration found = calibrated(simulated(seed));
    for (const Estimate& e : found.estimates) {
      const double z = (e.value - truth(e.name)) / e.sigma;
      EXPECT_LT(std::abs(z), 5) << e.name << " of seed " << seed << ": " << e.value << " +- " << e.sigma;
      squares += z * z, count += 1;
    }
    // What is left after fitting is a little less than the noise.
    EXPECT_NEAR(found.rms, std::sqrt(2) * kNoise, 0.02);
    EXPECT_LT(found.epipolar.rms, 1.5 * kNoise);
    // Noise in depth makes squares longer, never shorter: 30 mm and 4 mm across it are 30.3.
    EXPECT_NEAR(found.square.mean, 1.01, 0.01);
  }
  EXPECT_GT(count, 5 * 20);
  EXPECT_GT(std::sqrt(squares / count), 0.75) << "the stated deviations are too large";
  EXPECT_LT(std::sqrt(squares / count), 1.3) << "the stated deviations are too small";
}

TEST(CameraCalibration, FindsTheTruthWithinItsStandardDeviations) {
  double squares = 0, count = 0;
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    std::vector<BoardView> views;
    for (const BoardPair& pair : simulated(seed)) views.push_back(pair.left);
    views.insert(views.begin() + 3, BoardView{});
    const StereoRig rig = true_rig();
    const CameraCalibration found = calibrate_camera(kBoard, views, rig.left.width, rig.left.height);
    ASSERT_EQ(found.view_rms.size(), views.size());
    EXPECT_EQ(found.view_rms[3], 0) << "an empty view has no error";
    for (const Estimate& e : found.estimates) {
      const double z = (e.value - truth("left." + e.name)) / e.sigma;
      squares += z * z, count += 1;
    }
  }
  EXPECT_GT(std::sqrt(squares / count), 0.7);
  EXPECT_LT(std::sqrt(squares / count), 1.35);
}

TEST(StereoCalibration, IsExactWithoutNoise) {
  const StereoCalibration found = calibrated(simulated(7, 12, 0));
  for (const Estimate& e : found.estimates)
    EXPECT_NEAR(e.value, truth(e.name), 1e-3 * std::max(1.0, std::abs(truth(e.name)))) << e.name;
  EXPECT_LT(found.rms, 1e-3);
  EXPECT_NEAR(found.square.mean, 1, 1e-5);
}

TEST(StereoCalibration, NamesThePairWhoseCornersAreOff) {
  std::vector<BoardPair> pairs = simulated(11);
  for (Vector2d& pixel : pairs[6].right.pixels) pixel.y() += 2;  // as if one camera had moved
  const StereoCalibration found = calibrated(pairs);
  std::vector<double> epipolar;
  for (const PairError& e : found.pairs) epipolar.push_back(e.epipolar);
  std::vector<bool> expected(pairs.size(), false);
  expected[6] = true;
  EXPECT_EQ(standing_out(epipolar), expected);
}

TEST(StereoCalibration, NamesNoPairOfASoundSet) {
  int named = 0;
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    std::vector<double> errors;
    for (const PairError& e : calibrated(simulated(seed)).pairs) errors.push_back(e.left);
    for (const bool out : standing_out(errors)) named += out ? 1 : 0;
  }
  EXPECT_LE(named, 2) << "of 70 pairs";
}

TEST(StereoCalibration, SaysWhyItCannotBeDone) {
  EXPECT_THAT(message_of(simulated(1, 3)), HasSubstr("seen in 3 views, expected at least 4"));
  std::vector<BoardPair> swapped = simulated(1);
  for (BoardPair& pair : swapped) std::swap(pair.left, pair.right);
  EXPECT_THAT(message_of(swapped), HasSubstr("swap the cameras"));
  EXPECT_THAT(message_of(simulated(1, 8, kNoise, 0.005)), HasSubstr("turned to all sides"));
  Board unit = kBoard;
  unit.square = 1;
  EXPECT_THROW(calibrate_stereo(unit, simulated(1), 340, 480), InputError) << "4.8 m between the cameras";
}

TEST(StandingOut, IsRobust) {
  EXPECT_EQ(standing_out({}), std::vector<bool>{});
  EXPECT_EQ(standing_out({0.2}), std::vector<bool>{false});
  EXPECT_EQ(standing_out({0.2, 0.21, 0.19, 0.2, 5}), (std::vector<bool>{false, false, false, false, true}));
  EXPECT_EQ(standing_out({0.2, 0.2, 0.2, 0.2, 0.22}), std::vector<bool>(5, false)) << "10 % more is nothing";
  EXPECT_EQ(standing_out({9, 0.2, 0.21, 0.19, 9.5, 0.2}),
            (std::vector<bool>{true, false, false, false, true, false}));
}

/// OpenCV's chessboard pairs: in the project's data or Debian's opencv-doc.
std::filesystem::path chess_folder() {
  const char* data = std::getenv("HEADWAY_DATA");
  const std::filesystem::path own = std::filesystem::path(data ? data : "") / "stereo/chess";
  if (data && std::filesystem::exists(own / "left01.jpg")) return own;
  const std::filesystem::path debian = "/usr/share/doc/opencv-doc/examples/data";
  return std::filesystem::exists(debian / "left01.jpg") ? debian : std::filesystem::path();
}

TEST(StereoCalibration, OfOpenCvsChessboardPairsIsAsPrecise) {
  const std::filesystem::path folder = chess_folder();
  if (folder.empty()) GTEST_SKIP() << "neither HEADWAY_DATA/stereo/chess nor Debian's opencv-doc is there";
  const Board board{9, 6, 0.025, {}};
  std::vector<BoardPair> pairs;
  for (int i = 1; i <= 14; ++i) {
    const auto file = [&](const char* side) { return folder / fmt::format("{}{:02}.jpg", side, i); };
    if (!std::filesystem::exists(file("left"))) continue;
    pairs.push_back(
        {find_board(board, read_gray(file("left"))), find_board(board, read_gray(file("right")))});
    EXPECT_EQ(pairs.back().left.size() + pairs.back().right.size(), 108U) << i;
  }
  ASSERT_EQ(pairs.size(), 13U);
  // The published treatment of this set: one focal length, no tangential distortion.
  const StereoCalibration alike = calibrate_stereo(board, pairs, 640, 480, Lenses::kAlike);
  EXPECT_NEAR(alike.rms, 0.305, 0.02);
  EXPECT_LE(alike.epipolar.rms, 0.31);
  EXPECT_NEAR(alike.square.mean, 0.997, 0.003);
  EXPECT_NEAR(alike.rig.baseline() / board.square, 3.33, 0.01);
  EXPECT_EQ(alike.rig.left.fx, alike.rig.right.fx);
  EXPECT_EQ(alike.rig.left.p1, 0);
  // Lenses of their own fit it better.
  const StereoCalibration each = calibrate_stereo(board, pairs, 640, 480);
  EXPECT_LT(each.rms, 0.23);
  EXPECT_LT(each.epipolar.rms, 0.2);
  EXPECT_NEAR(each.square.mean, 1, 0.003);
  EXPECT_NEAR(each.rig.baseline() / board.square, 3.33, 0.01);
}

}  // namespace
}  // namespace headway::vision
