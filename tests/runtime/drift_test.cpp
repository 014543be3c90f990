// Odometry that errs in known ways, and alignments as views would give them.
#include "runtime/drift.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"

namespace headway::runtime {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

double normal(std::mt19937_64& random) {
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2 * std::log(uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}

/// A robot that walks in a circle 3 m wide, as its odometry has it and as it is.
struct Walker {
  double stride = 0, swerve = 0;  ///< what odometry does not know
  DriftConfig noise{.shift = 0, .turn = 0, .turn_of_turn = 0};
  std::mt19937_64 random{1};
  Pose2 odom{}, truth{};
  Time now{};

  /// A tenth of a second at 0.25 m/s.
  void step() {
    const Pose2 told{0.025, 0, 0.0167};
    const double shift = noise.shift * std::sqrt(told.x);
    Pose2 done{
        told.x * (1 + stride) + shift * normal(random), shift * normal(random),
        told.yaw + 0.1 * swerve +
            std::sqrt(0.1 * noise.turn * noise.turn + told.yaw * noise.turn_of_turn * noise.turn_of_turn) *
                normal(random)};
    odom = odom * told;
    truth = truth * done;
    now += seconds(0.1);
  }
  Vector3d error(const Drift& drift) const {
    const Pose2 p = drift.map_from_robot();
    return {p.x - truth.x, p.y - truth.y, wrap_angle(p.yaw - truth.yaw)};
  }
  /// What a view tells that sees along the directions that are not zero in `sees`.
  nav::Alignment look(const Drift& drift, const Vector3d& sigma, const Vector3d& sees = {1, 1, 1}) {
    nav::Alignment a;
    a.aligned = nav::Aligned::kWhole;
    for (int i = 0; i < 3; ++i) {
      if (sees[i] == 0) continue;
      a.change[i] = -error(drift)[i] + sigma[i] * normal(random);
      a.information(i, i) = 1 / (sigma[i] * sigma[i]);
    }
    return a;
  }
};

const Vector3d kSigma(0.003, 0.003, 0.002);

TEST(Drift, IsNoneWhileTheRobotStands) {
  Drift drift;
  const Pose2 start{1, 2, 0.3};
  for (int i = 0; i < 100; ++i) drift.move(start, at_seconds(0.1 * i));
  EXPECT_TRUE(drift.covariance().isZero());
  nav::Alignment a;
  a.aligned = nav::Aligned::kWhole;
  a.change = {0.1, 0.1, 0.1};
  a.information = 1e6 * Matrix3d::Identity();
  drift.correct(a);
  EXPECT_DOUBLE_EQ(drift.map_from_robot().x, start.x);
  EXPECT_DOUBLE_EQ(drift.map_from_robot().yaw, start.yaw);
  EXPECT_NEAR(drift.map_from_odom().position().norm(), 0, 1e-12);
}

TEST(Drift, IsFollowedAndItsSteadyPartFoundOut) {
  Walker walker{.stride = -0.02, .swerve = 0.003};
  Drift drift;
  for (int i = 0; i < 300; ++i) {
    walker.step();
    drift.move(walker.odom, walker.now);
    drift.correct(walker.look(drift, kSigma));
    if (i > 20) {
      ASSERT_LT(walker.error(drift).head<2>().norm(), 0.01) << i;
      ASSERT_LT(std::abs(walker.error(drift).z()), 0.006) << i;
    }
  }
  EXPECT_NEAR(drift.stride(), walker.stride, 0.003);
  EXPECT_NEAR(drift.swerve(), walker.swerve, 0.0006);
  EXPECT_GT((walker.odom.position() - walker.truth.position()).norm(), 0.1) << "or there was nothing to find";
  // From now on without a look.
  const Pose2 odom = walker.odom, truth = walker.truth;
  for (int i = 0; i < 120; ++i) {
    walker.step();
    drift.move(walker.odom, walker.now);
  }
  const double blind = (truth.inverse() * walker.truth).position().norm(),
               told = (odom.inverse() * walker.odom).position().norm();
  EXPECT_GT(std::abs(blind - told), 0.04);
  EXPECT_LT(walker.error(drift).head<2>().norm(), 0.02);
}

TEST(Drift, IsAsSureAsItCanBe) {
  std::mt19937_64 random(3);
  double squares = 0;
  int counted = 0;
  for (std::uint64_t run = 0; run < 60; ++run) {
    const DriftConfig config;
    Walker walker{
        .stride = config.stride * normal(random), .swerve = config.swerve * normal(random), .noise = config};
    walker.random.seed(100 + run);
    Drift drift(config);
    for (int i = 0; i < 150; ++i) {
      walker.step();
      drift.move(walker.odom, walker.now);
      const Vector3d sees(i % 7 == 0, i % 11 == 0, i % 5 == 0);  // a wall now here, now there
      drift.correct(walker.look(drift, kSigma, sees));
      if (i % 50 != 49) continue;
      const Vector3d error = walker.error(drift);
      squares += error.dot(drift.covariance().inverse() * error);
      counted += 3;
    }
  }
  EXPECT_GT(squares / counted, 0.75);
  EXPECT_LT(squares / counted, 1.3);
}

TEST(Drift, IsLeftAloneAlongWhatAViewDoesNotTell) {
  Walker walker{.stride = 0.05};
  Drift drift;
  for (int i = 0; i < 2; ++i) {
    walker.step();
    drift.move(walker.odom, walker.now);
  }
  const Pose2 before = drift.map_from_robot();
  nav::Alignment across = walker.look(drift, kSigma, {0, 1, 0});
  across.change.y() = 0.001;
  drift.correct(across);
  EXPECT_NEAR(drift.map_from_robot().x, before.x, 1e-4);
  EXPECT_GT(drift.map_from_robot().y, before.y);
}

TEST(Drift, IsDoubtedMoreWhenViewsContradictIt) {
  Walker walker;
  Drift drift;
  for (int i = 0; i < 10; ++i) {
    walker.step();
    drift.move(walker.odom, walker.now);
  }
  const Pose2 before = drift.map_from_robot();
  const Matrix3d doubt = drift.covariance();
  nav::Alignment refused;
  refused.aligned = nav::Aligned::kMisfit;
  drift.correct(refused);
  EXPECT_EQ(drift.covariance(), doubt);
  refused.aligned = nav::Aligned::kTooFar;
  drift.correct(refused);
  EXPECT_EQ(drift.map_from_robot().x, before.x);
  EXPECT_GT(drift.covariance()(0, 0), doubt(0, 0));
  EXPECT_LT(drift.covariance()(0, 0), 1.5 * doubt(0, 0)) << "one view may be wrong";
  for (int i = 0; i < 10; ++i) drift.correct(refused);
  EXPECT_GT(drift.covariance()(0, 0), 4 * doubt(0, 0)) << "a second of them is not";
}

RC_GTEST_PROP(Drift, NeverBecomesLessSureByLooking, ()) {
  const auto number = [](double bound) { return bound * (*rc::gen::inRange(-1000, 1001)) / 1000.0; };
  Drift drift;
  Pose2 odom;
  for (int i = 1; i < 30; ++i) {
    odom = odom * Pose2{number(0.05), number(0.05), number(0.1)};
    drift.move(odom, at_seconds(0.1 * i));
    Matrix3d root;
    for (int k = 0; k < 9; ++k) root(k / 3, k % 3) = number(300);
    if (i % 3 == 0) root.row(0).setZero();
    if (i % 4 == 0) root.row(1).setZero();
    nav::Alignment a;
    a.aligned = nav::Aligned::kPartly;
    a.information = root.transpose() * root;
    a.change = {number(0.01), number(0.01), number(0.01)};
    const Matrix3d before = drift.covariance();
    drift.correct(a);
    const Matrix3d after = drift.covariance();
    RC_ASSERT(after.isApprox(after.transpose()));
    const double scale = before.norm() + 1e-12;
    RC_ASSERT(Eigen::SelfAdjointEigenSolver<Matrix3d>(after).eigenvalues().minCoeff() > -1e-9 * scale);
    RC_ASSERT(Eigen::SelfAdjointEigenSolver<Matrix3d>(before - after).eigenvalues().minCoeff() >
              -1e-9 * scale);
  }
}

TEST(Drift, NamesASettingOutOfBounds) {
  try {
    Drift drift({.stride = -1});
    FAIL();
  } catch (const InputError& fault) {
    EXPECT_NE(std::string(fault.what()).find("stride"), std::string::npos);
  }
}

}  // namespace
}  // namespace headway::runtime
