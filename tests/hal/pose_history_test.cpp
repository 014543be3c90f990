#include "hal/pose_history.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::hal {
namespace {

using Small = History<HeadAngles, 4>;
constexpr Duration kGap = std::chrono::milliseconds(50);

Time ms(int t) { return Time(std::chrono::milliseconds(t)); }

TEST(History, KnowsNothingFromLessThanTwoSamples) {
  Small h;
  EXPECT_TRUE(h.empty());
  EXPECT_FALSE(h.at(ms(0), kGap));
  h.add(ms(10), {0.1, 0});
  EXPECT_FALSE(h.at(ms(10), kGap));
}

TEST(History, InterpolatesBetweenNeighbours) {
  Small h;
  h.add(ms(10), {0.0, 1.0});
  h.add(ms(20), {1.0, 0.0});
  h.add(ms(40), {3.0, 2.0});
  EXPECT_NEAR(h.at(ms(15), kGap)->pan, 0.5, 1e-12);
  EXPECT_NEAR(h.at(ms(25), kGap)->pan, 1.5, 1e-12);
  EXPECT_NEAR(h.at(ms(25), kGap)->tilt, 0.5, 1e-12);
}

TEST(History, GivesSamplesBackAtTheirOwnTimes) {
  Small h;
  for (int t : {10, 20, 40}) h.add(ms(t), {t * 0.1, 0});
  for (int t : {10, 20, 40}) EXPECT_NEAR(h.at(ms(t), kGap)->pan, t * 0.1, 1e-12);
}

TEST(History, NeverExtrapolates) {
  Small h;
  h.add(ms(10), {});
  h.add(ms(20), {});
  EXPECT_FALSE(h.at(ms(9), kGap));
  EXPECT_FALSE(h.at(ms(21), kGap));
}

TEST(History, SaysNothingWithinAGapThatIsTooWide) {
  Small h;
  h.add(ms(10), {});
  h.add(ms(20), {});
  h.add(ms(80), {});
  EXPECT_FALSE(h.at(ms(50), kGap));
  EXPECT_TRUE(h.at(ms(15), kGap));
}

TEST(History, IgnoresWhatIsNotNewer) {
  Small h;
  EXPECT_TRUE(h.add(ms(10), {1, 0}));
  EXPECT_FALSE(h.add(ms(10), {2, 0}));
  EXPECT_FALSE(h.add(ms(5), {3, 0}));
  EXPECT_EQ(h.newest(), ms(10));
}

TEST(History, ForgetsTheOldestFirst) {
  Small h;
  for (int t = 0; t <= 60; t += 10) h.add(ms(t), {t * 1.0, 0});
  EXPECT_FALSE(h.at(ms(29), kGap));
  EXPECT_NEAR(h.at(ms(30), kGap)->pan, 30, 1e-12);
  EXPECT_NEAR(h.at(ms(60), kGap)->pan, 60, 1e-12);
}

RC_GTEST_PROP(History, AgreesWithTheLineItWasSampledFrom, ()) {
  History<HeadAngles, 16> h;
  const double slope = *rc::gen::inRange(-1000, 1000) * 1e-2;
  int t = 0;
  for (int i = 0; i < 40; ++i) {
    t += *rc::gen::inRange(1, 50);
    h.add(ms(t), {slope * t, -slope * t});
  }
  const int asked = *rc::gen::inRange(0, t + 20);
  const auto got = h.at(ms(asked), kGap);
  if (asked > t) RC_ASSERT(!got);
  if (got) {
    RC_ASSERT(std::abs(got->pan - slope * asked) < 1e-6);
    RC_ASSERT(std::abs(got->tilt + slope * asked) < 1e-6);
  }
}

TEST(Interpolation, TurnsAtConstantRateAndMovesStraight) {
  const Eigen::Isometry3d a = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d b = a;
  b.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()).toRotationMatrix();
  b.translation() << 1, 2, 3;
  const Eigen::Isometry3d q = interpolate(a, b, 0.25);
  EXPECT_NEAR(Eigen::AngleAxisd(q.linear()).angle(), 0.1, 1e-12);
  EXPECT_LT((q.translation() - Eigen::Vector3d(0.25, 0.5, 0.75)).norm(), 1e-12);
}

}  // namespace
}  // namespace headway::hal
