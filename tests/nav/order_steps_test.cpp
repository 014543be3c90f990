#include "nav/walking/order_steps.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/nav/random_floor.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d;
using hal::Foot;
using hal::Stance;
using hal::WalkOrder;
using Kind = WalkOrder::Kind;

const GaitLimits kGait;
const Stance kStand = Stance::parallel({1, 2, 0.5}, kGait.feet_apart);

/// Where the steps of an order take the base, seen from where it began; each step keeps the limits.
std::vector<Pose2> bases(const WalkOrder& order, Stance stance = kStand, std::optional<Foot> last = {}) {
  const auto steps = steps_of(order, stance, last, kGait);
  std::vector<Pose2> out;
  if (!steps) return out;
  const Pose2 begin = gait_base(stance, last, kGait);
  for (const hal::Footstep& step : steps->all()) {
    EXPECT_TRUE(within_limits(step, kGait));
    EXPECT_NE(step.foot, last);
    last = step.foot;
    stance = stance.after(step);
    out.push_back(begin.inverse() * gait_base(stance, last, kGait));
  }
  return out;
}

WalkOrder some_order(Dice& dice) {
  switch (dice.whole(0, 4)) {
    case 0:
      return {Kind::kArc, 0, 0, dice.real(-2, 2)};
    case 1:
      return {Kind::kArc, dice.real(-0.2, 0.2), dice.real(0.5, 3), dice.real(-0.6, 0.6)};
    case 2:
      return {Kind::kNextStep, dice.real(0, 0.14), dice.real(-0.005, 0.005), dice.real(-0.06, 0.06)};
    default:
      return {Kind::kStraightWithTurn, dice.real(0, 3), dice.real(-0.3, 0.3), dice.real(-0.5, 0.5)};
  }
}

TEST(OrderSteps, TakeTheBaseWhereTheOrderSays) {
  Dice dice(17);
  int expanded = 0;
  for (int run = 0; run < 2000; ++run) {
    const WalkOrder order = hal::quantised(some_order(dice));
    Stance stance = kStand;
    std::optional<Foot> last;
    if (run % 2 == 0) {  // amid a walk
      last = run % 4 == 0 ? Foot::kLeft : Foot::kRight;
      const double side = run % 4 == 0 ? 1 : -1;
      stance = stance.after(
          hal::quantised({*last,
                          {dice.real(0, 0.14), side * dice.real(0.185, 0.23), dice.real(-0.08, 0.08)},
                          0,
                          seconds(0.8)}));
    }
    const auto way = bases(order, stance, last);
    if (way.empty()) continue;
    ++expanded;
    const Pose2 end = order.kind == Kind::kArc
                          ? Pose2{order.x, order.y, order.turn} * Pose2{-order.x, -order.y, 0}
                          : Pose2{order.x, order.y, order.turn};
    ASSERT_LT((way.back().position() - end.position()).norm(), 1.2e-3) << "run " << run;
    ASSERT_NEAR(wrap_angle(way.back().yaw - end.yaw), 0, 1.1e-3) << "run " << run;
    ASSERT_LE(way.size(), OrderSteps::kMost);
  }
  EXPECT_GT(expanded, 1500);
}

TEST(OrderSteps, OfAStraightAreAsLongAndAsFewAsTheyMayBe) {
  const auto way = bases({Kind::kStraightWithTurn, 2.0, 0, 0});
  ASSERT_EQ(way.size(), 10U);
  for (std::size_t i = 0; i < way.size(); ++i) EXPECT_NEAR(way[i].x, 0.2 * static_cast<double>(i + 1), 1e-3);
  EXPECT_EQ(bases({Kind::kStraightWithTurn, 0, 0.3, 0}).size(), 11U)
      << "two for each 5 cm, the outer foot first";
  EXPECT_TRUE(bases({Kind::kStraightWithTurn, 8, 0, 0}).empty()) << "too many";
  EXPECT_TRUE(bases({Kind::kStraightWithTurn, -0.5, 0, 0}, kStand, Foot::kLeft).size() > 20)
      << "backward: 2 cm a step";
}

TEST(OrderSteps, OfAnArcKeepTheirDistanceFromItsCentre) {
  for (const double side : {-1.0, 1.0}) {
    const auto way = bases({Kind::kArc, 0, side * 1.5, side * 0.8});
    ASSERT_GE(way.size(), 8U);
    for (const Pose2& base : way) {
      EXPECT_NEAR((base.position() - Vector2d(0, side * 1.5)).norm(), 1.5, 1.5e-3);
      EXPECT_NEAR(std::atan2(base.x, 1.5 - side * base.y), side * base.yaw, 2e-3) << "it faces along the arc";
    }
  }
}

TEST(OrderSteps, TurnOnTheSpotAroundTheBase) {
  for (const Pose2& base : bases({Kind::kArc, 0, 0, -1.5})) EXPECT_LT(base.position().norm(), 1.2e-3);
}

TEST(OrderSteps, OfTheNextStepAreOne) {
  EXPECT_EQ(bases({Kind::kNextStep, 0.15, 0, 0.01}).size(), 1U);
  EXPECT_TRUE(bases({Kind::kNextStep, 0.3, 0, 0}).empty());
}

}  // namespace
}  // namespace headway::nav
