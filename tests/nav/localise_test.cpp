// Views of exact rooms, said to be seen from elsewhere than they are.
#include "nav/localise.h"

#include <cmath>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/surface_matching/icp.hpp>

#include "hal/error.h"
#include "known_room.h"
#include "nav/cold_map_file.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

const Vector3d kEye(0, 0, 1.4);
const Vector3d kSigma(0.01, 0.01, 0.005);

Vector3d drawn(std::mt19937_64& random, const Vector3d& sigma) {
  return {sigma.x() * normal(random), sigma.y() * normal(random), sigma.z() * normal(random)};
}

Isometry3d any_pose(std::mt19937_64& random) {
  return camera_pose(kEye + Vector3d(0.6 * uniform(random) - 0.3, 0.6 * uniform(random) - 0.3, 0),
                     6.28 * uniform(random), 0.3 * uniform(random));
}

TEST(Localiser, FindsAChangeWithinTheCovarianceThatItGives) {
  std::mt19937_64 random(1);
  const LocaliseConfig config;
  const Vector3d alike(config.shift_sigma, config.shift_sigma, config.turn_sigma);
  double squares = 0;
  int directions = 0, aligned = 0, beyond = 0;
  for (std::uint64_t r = 0; r < 6; ++r) {
    KnownRoom known(random_room(random));
    known.look_around(kEye, 1000 * r);
    for (std::uint64_t i = 0; i < 25; ++i) {
      const Vector3d change = drawn(random, kSigma);
      const Alignment a = known.align(any_pose(random), change, 1000 * r + 500 + i, kSigma);
      if (!a) continue;
      ++aligned;
      directions += a.determined;
      // What the neck adds to a view is seen as part of the change.
      const Vector3d error = a.change - change - drawn(random, alike);
      const double square = error.dot(a.information * error);
      squares += square;
      beyond += square > 16.3;
    }
  }
  EXPECT_GE(aligned, 140);
  EXPECT_GE(directions, 2 * aligned);
  EXPECT_GT(squares / directions, 0.7) << "more modest than it need be";
  EXPECT_LT(squares / directions, 1.3) << "more sure than it can be";
  EXPECT_LE(beyond, 1);
}

TEST(Localiser, FindsTheSameWithAMapThatWasSavedAndRestored) {
  std::mt19937_64 random(11);
  KnownRoom known(random_room(random));
  known.look_around(kEye, 1);
  const Isometry3d pose = any_pose(random);
  const Vector3d change(0.03, -0.02, 0.01), sigma(0.03, 0.03, 0.01);
  const Alignment before = known.align(pose, change, 77, sigma);
  ASSERT_TRUE(before);
  std::stringstream file;
  write_map_file(known.map, known.surfaces, file);
  known.surfaces = SurfacePoints(known.map.resolution());
  EXPECT_FALSE(known.align(pose, change, 77, sigma)) << "without the surfaces nothing is aligned";
  known.surfaces = read_saved_map(file, "room.hmap").surfaces;
  const Alignment after = known.align(pose, change, 77, sigma);
  EXPECT_EQ(after.change, before.change);
  EXPECT_EQ(after.information, before.information);
}

TEST(Localiser, AlignsWithAMapOfVersion2) {
  std::mt19937_64 random(11);
  KnownRoom known(random_room(random));
  known.look_around(kEye, 1);
  const Isometry3d pose = any_pose(random);
  const Vector3d change(0.03, -0.02, 0.01);
  const Vector3d sigma(0.03, 0.03, 0.01);
  const Alignment with_rays = known.align(pose, change, 77, sigma);
  known.surfaces = without_rays(known.surfaces);
  const Alignment without = known.align(pose, change, 77, sigma);
  ASSERT_TRUE(with_rays && without);
  EXPECT_EQ(without.determined, with_rays.determined);
  EXPECT_LT((without.change - with_rays.change).norm(), 0.003);
}

TEST(Localiser, IsExactToMillimetresWhereItSaysSo) {
  std::mt19937_64 random(2);
  double worst = 0, worst_turn = 0;
  int sure = 0;
  for (std::uint64_t r = 0; r < 6; ++r) {
    KnownRoom known(random_room(random));
    known.look_around(kEye, 1000 * r);
    for (std::uint64_t i = 0; i < 15; ++i) {
      const Vector3d change = drawn(random, kSigma);
      const Alignment a = known.align(any_pose(random), change, 1000 * r + 500 + i, kSigma);
      if (a.aligned != Aligned::kWhole) continue;
      if (a.information.inverse().diagonal().head<2>().maxCoeff() > 0.004 * 0.004) continue;
      ++sure;
      worst = std::max(worst, (a.change - change).head<2>().norm());
      worst_turn = std::max(worst_turn, std::abs(a.change.z() - change.z()));
    }
  }
  EXPECT_GE(sure, 20);
  EXPECT_LT(worst, 0.012) << "three sigma";
  EXPECT_LT(worst_turn, 0.004);
}

TEST(Localiser, LeavesAPoseThatIsRightAlone) {
  KnownRoom known(SyntheticRoom::furnished());
  known.look_around(kEye, 0);
  for (const double yaw : {0.4, 1.5, -2.0}) {
    const Alignment a = known.align(camera_pose(kEye, yaw, 0.1), Vector3d::Zero(), 99, kSigma);
    ASSERT_TRUE(a) << name(a.aligned);
    EXPECT_LT(a.change.head<2>().norm(), 0.003);
    EXPECT_LT(std::abs(a.change.z()), 0.002);
  }
}

/// Walls far away but for those that are given.
SyntheticRoom open_place() {
  SyntheticRoom room;
  room.walls = {{-50, -50, 0}, {50, 50, 20}};
  return room;
}

TEST(Localiser, RefusesToMoveAlongASingleWall) {
  SyntheticRoom room = open_place();
  room.walls.highest.x() = 2.02;
  KnownRoom known(room);
  known.look_around(kEye, 0, -1, 1);
  for (const double yaw : {0.0, 0.4, -0.4}) {
    const Vector3d change(0.02, 0.05, 0.01);
    const Alignment a = known.align(camera_pose(kEye, yaw, 0.1), change, 77, {0.05, 0.05, 0.02});
    ASSERT_EQ(a.aligned, Aligned::kPartly);
    EXPECT_NEAR(a.change.x(), change.x(), 0.004);
    EXPECT_NEAR(a.change.z(), change.z(), 0.004);
    EXPECT_NEAR(a.change.y(), 0, 0.002);
    EXPECT_LT(a.information(1, 1), 1e-3 * a.information(0, 0));
  }
}

// Far off, noise is as large as what the voxels of a wall span, and their normals point anywhere. Beyond the
// end of what is known the patches lie to one side of those planes, so such normals all pull the same way.
/// A view that hardly overlaps with what is known.
TEST(Localiser, SaysNothingWhereLittleOfTheViewIsKnown) {
  SyntheticRoom room = open_place();
  room.walls.highest.x() = 3.52;
  KnownRoom known(room);
  for (std::uint64_t view = 0; view < 4; ++view) known.learn(camera_pose(kEye, 0.25, 0.1), view);
  const auto align = [&] { return known.align(camera_pose(kEye, -0.2, 0.1), Vector3d::Zero(), 50, kSigma); };
  const Alignment refused = align();
  EXPECT_EQ(refused.aligned, Aligned::kFewPatches);
  EXPECT_TRUE(refused.change.isZero());
  LocaliseConfig config;
  config.least_known = 0;
  known.localiser = Localiser(config);
  const Alignment taken = align();
  EXPECT_TRUE(taken);
  EXPECT_LT(static_cast<double>(taken.matched), 0.25 * static_cast<double>(taken.patches));
}

TEST(Localiser, IsNotTurnedWhereTheKnownPartOfAFarWallEnds) {
  SyntheticRoom room = open_place();
  room.walls.highest.x() = 3.52;
  LocaliseConfig config;
  config.least_known = 0;  // it is that part which is looked at
  for (const double side : {-1.0, 1.0}) {
    Vector3d sum = Vector3d::Zero();
    int aligned = 0;
    for (std::uint64_t r = 0; r < 24; ++r) {
      KnownRoom known(room);
      known.localiser = Localiser(config);
      for (std::uint64_t view = 0; view < 4; ++view)
        known.learn(camera_pose(kEye, 0.25 * side, 0.1), 100 * r + view);
      for (std::uint64_t view = 0; view < 5; ++view) {
        const Alignment a =
            known.align(camera_pose(kEye, -0.15 * side, 0.1), Vector3d::Zero(), 100 * r + 50 + view, kSigma);
        if (!a) continue;
        sum += a.change;
        ++aligned;
      }
    }
    EXPECT_GE(aligned, 90);
    EXPECT_NEAR(sum.z() / aligned, 0, LocaliseConfig{}.turn_sigma) << side;
    EXPECT_NEAR(sum.x() / aligned, 0, 0.002) << side;
  }
}

TEST(Localiser, RefusesToMoveAlongACorridor) {
  SyntheticRoom room = open_place();
  room.walls.lowest.y() = -0.83;
  room.walls.highest.y() = 0.91;
  KnownRoom known(room);
  known.camera = camera_of(240, 170, 1.6);  // that sees both walls at once
  known.look_around(kEye, 0);
  const Vector3d change(0.05, -0.02, 0.01);
  const Alignment a = known.align(camera_pose(kEye, 0.03, 0.1), change, 77, {0.05, 0.05, 0.02});
  ASSERT_EQ(a.aligned, Aligned::kPartly);
  EXPECT_NEAR(a.change.y(), change.y(), 0.004);
  EXPECT_NEAR(a.change.z(), change.z(), 0.004);
  EXPECT_NEAR(a.change.x(), 0, 0.002);
  EXPECT_LT(a.information(0, 0), 1e-3 * a.information(1, 1));
}

// Wherever the wall stands in its voxels and blocks.
TEST(Localiser, DoesNotTakeOneFaceOfAThinWallForTheOther) {
  int told = 0;
  const Vector3d here(-0.6, 0, 1.4), there(2.6, 0, 1.4), sigma(0.05, 0.05, 0.02);
  const Isometry3d ahead = camera_pose(here, 0, 0.1), back = camera_pose(there, std::numbers::pi, 0.1);
  for (double face = 0.9; face < 1.105; face += 0.04) {
    SyntheticRoom room = open_place();
    room.solids = {{{face, -3, 0}, {face + 0.1, 3, 3}}};
    KnownRoom known(room);
    known.look_around(here, 0, -0.6, 0.6);
    ASSERT_TRUE(known.align(ahead, Vector3d::Zero(), 77, sigma)) << face;
    EXPECT_EQ(known.align(back, Vector3d::Zero(), 78, sigma).aligned, Aligned::kFewPatches) << face;
    for (std::uint64_t view = 0; view < 6; ++view) known.learn(back, 100 + view);
    for (const Isometry3d& pose : {ahead, back}) {
      const Alignment a = known.align(pose, {0.02, 0, 0}, 79, sigma);
      if (!a) continue;  // both faces lie in one block
      EXPECT_NEAR(a.change.x(), 0.02, 0.01) << face << ", with both faces known";
      ++told;
    }
  }
  EXPECT_GE(told, 6);
}

TEST(Localiser, LearnsNothingFromTheFloor) {
  KnownRoom known(open_place());
  known.look_around(kEye, 0);
  const Alignment a = known.align(camera_pose(kEye, 0, 0.9), {0.02, 0.02, 0.01}, 77, kSigma);
  EXPECT_EQ(a.aligned, Aligned::kFewPatches);
  EXPECT_TRUE(a.information.isZero());
  EXPECT_TRUE(a.correction().isApprox(Isometry3d::Identity()));
}

TEST(Localiser, IsNotPulledByABoxThatWasMoved) {
  SyntheticRoom room = SyntheticRoom::furnished();
  room.solids = {{{1.2, -0.3, 0}, {1.6, 0.3, 1.3}}};
  for (const double moved : {0.04, 0.08, 0.3, 2.0}) {
    KnownRoom known(room);
    known.look_around(kEye, 0);
    known.room.solids[0].lowest.y() += moved;
    known.room.solids[0].highest.y() += moved;
    known.room.solids[0].lowest.x() += moved / 2;
    known.room.solids[0].highest.x() += moved / 2;
    // Towards the corner behind the box, so that the walls tell the place.
    const Alignment a = known.align(camera_pose(kEye, -0.55, 0), {0.01, -0.01, 0.005}, 7, kSigma);
    ASSERT_TRUE(a) << name(a.aligned) << ", moved by " << moved;
    EXPECT_NEAR(a.change.x(), 0.01, 0.006) << moved;
    EXPECT_NEAR(a.change.y(), -0.01, 0.006) << moved;
    EXPECT_NEAR(a.change.z(), 0.005, 0.004) << moved;
  }
}

TEST(Localiser, RefusesWhatThePoseCannotBeOff) {
  KnownRoom known(SyntheticRoom::furnished());
  known.look_around(kEye, 0);
  const Alignment a = known.align(camera_pose(kEye, 0.4, 0.1), {0.05, 0.04, 0}, 5, {0.006, 0.006, 0.003});
  EXPECT_EQ(a.aligned, Aligned::kTooFar);
  EXPECT_TRUE(a.change.isZero());
  EXPECT_TRUE(a.information.isZero());
}

TEST(Localiser, RefusesAPlaceThatItDoesNotKnow) {
  KnownRoom known(SyntheticRoom::furnished());
  known.look_around(kEye, 0, -0.5, 0.5);
  EXPECT_EQ(known.align(camera_pose(kEye, 3.0, 0.1), Vector3d::Zero(), 5, kSigma).aligned,
            Aligned::kFewPatches);
}

TEST(Localiser, RefusesAnotherRoom) {
  std::mt19937_64 random(3);
  KnownRoom known(SyntheticRoom::furnished());
  known.look_around(kEye, 0);
  int believed = 0;
  for (std::uint64_t i = 0; i < 10; ++i) {
    known.room = random_room(random);
    believed += static_cast<bool>(known.align(any_pose(random), Vector3d::Zero(), i, kSigma));
  }
  EXPECT_LE(believed, 3) << "a wall that happens to stand where another stood";
}

TEST(Localiser, RefusesAViewThatDoesNotFitAsItsPatchesSay) {
  KnownRoom known(SyntheticRoom::furnished());
  known.look_around(kEye, 0);
  const Isometry3d pose = camera_pose(kEye, 0.4, 0.1);
  view_patches(known.see(pose, 5), {}, known.patches);
  const auto aligned = [&](const LocaliseConfig& config) {
    return Localiser(config)
        .align(known.map, known.surfaces, known.patches, pose, kEye.head<2>(),
               kSigma.cwiseAbs2().asDiagonal())
        .aligned;
  };
  EXPECT_EQ(aligned({}), Aligned::kPartly);
  // Points that scatter by centimetres and claim a tenth of a millimetre.
  std::mt19937_64 random(1);
  for (Patch& patch : known.patches) {
    patch.point *= 1 + 0.02 * (2 * uniform(random) - 1);
    patch.sigma = 1e-4;
  }
  EXPECT_EQ(aligned({.least_share = 0, .largest_misfit = 100}), Aligned::kPartly);
  EXPECT_EQ(aligned({.least_share = 0}), Aligned::kMisfit);
}

TEST(Localiser, GivesTheSameForTheSame) {
  const auto run = [] {
    KnownRoom known(SyntheticRoom::furnished());
    known.look_around(kEye, 0, -1, 1);
    return known.align(camera_pose(kEye, 0.4, 0.1), {0.01, 0.02, 0.01}, 5, kSigma);
  };
  const Alignment a = run(), b = run();
  EXPECT_EQ(a.change, b.change);
  EXPECT_EQ(a.information, b.information);
}

TEST(Localiser, NamesASettingOutOfBounds) {
  LocaliseConfig config;
  config.gate = 0;
  try {
    Localiser localiser(config);
    FAIL();
  } catch (const InputError& fault) {
    EXPECT_NE(std::string(fault.what()).find("gate"), std::string::npos);
  }
}

/// Points with normals for OpenCV, in the map frame; the normals of the room's surfaces there.
cv::Mat cloud(const SyntheticRoom& room, const std::vector<Vector3d>& points) {
  cv::Mat out(static_cast<int>(points.size()), 6, CV_32F);
  for (int i = 0; i < out.rows; ++i) {
    const Vector3d& p = points[static_cast<std::size_t>(i)];
    Vector3d normal;
    for (int k = 0; k < 3; ++k)
      normal[k] = room.clearance(p + 1e-3 * Vector3d::Unit(k)) - room.clearance(p - 1e-3 * Vector3d::Unit(k));
    normal.normalize();
    for (int k = 0; k < 3; ++k) {
      out.at<float>(i, k) = static_cast<float>(p[k]);
      out.at<float>(i, k + 3) = static_cast<float>(normal[k]);
    }
  }
  return out;
}

// The oracle knows no map: it brings the view onto an exact view from the true place.
TEST(Localiser, AgreesWithOpenCvsIcp) {
  KnownRoom known(SyntheticRoom::furnished());
  known.camera = camera_of(240, 170, 1.2);
  known.look_around(kEye, 0);
  for (const double yaw : {0.4, -0.6, 2.5}) {
    const Isometry3d pose = camera_pose(kEye, yaw, 0.1);
    const Vector3d change(0.02, -0.03, 0.01);
    const Alignment a = known.align(pose, change, 11, {0.03, 0.03, 0.02});
    ASSERT_EQ(a.aligned, Aligned::kWhole) << yaw;

    std::vector<Patch> exact;
    view_patches(look(known.room, known.camera, pose, {}, 0.05, 0.6, 6.0), {}, exact);
    std::vector<Vector3d> scene, model;
    for (const Patch& p : exact) scene.push_back(pose * p.point);
    for (const Patch& p : known.patches) model.push_back(pose * p.point);
    cv::Mat moved = cloud(known.room, model);
    // Moved back by the change about the eye: that is what the Localiser was told.
    const Eigen::Matrix3d back = Eigen::AngleAxisd(-change.z(), Vector3d::UnitZ()).toRotationMatrix();
    for (int i = 0; i < moved.rows; ++i) {
      const Vector3d p(moved.at<float>(i, 0), moved.at<float>(i, 1), moved.at<float>(i, 2));
      const Vector3d n(moved.at<float>(i, 3), moved.at<float>(i, 4), moved.at<float>(i, 5));
      const Vector3d q = kEye - Vector3d(change.x(), change.y(), 0) + back * (p - kEye), m = back * n;
      for (int k = 0; k < 3; ++k) {
        moved.at<float>(i, k) = static_cast<float>(q[k]);
        moved.at<float>(i, k + 3) = static_cast<float>(m[k]);
      }
    }
    cv::ppf_match_3d::ICP icp(100, 0.005F, 2.5F, 4);
    double residual = 0;
    cv::Matx44d found;
    ASSERT_EQ(icp.registerModelToScene(moved, cloud(known.room, scene), residual, found), 0);
    const auto corrected = [&](const Vector3d& p) {
      const cv::Vec4d q = found * cv::Vec4d(p.x(), p.y(), p.z(), 1);
      return Vector3d(q[0], q[1], q[2]);
    };
    const Vector3d ahead = pose * Vector3d(0, 0, 2);
    for (const Vector3d& p : {kEye, ahead})
      EXPECT_LT((corrected(p) - a.correction() * p).head<2>().norm(), 0.008) << yaw;
  }
}

}  // namespace
}  // namespace headway::nav
