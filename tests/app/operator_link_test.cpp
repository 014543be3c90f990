// The operator's link breaks while the robot walks.
#include <algorithm>
#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim_hal/dice.h"
#include "tests/app/served_robot.h"

namespace headway::app {
namespace {

using runtime::MissionState;

constexpr Duration kRenews = seconds(0.2), kNoticed = seconds(1), kRests = seconds(2.7);
/// Until the control computer has said so: a few of its statuses.
constexpr Duration kTold = seconds(0.1);

/// Holds the robot to its promise: at rest in time after a renewal that was the last, and for good.
struct Link : Served {
  bool stands() const { return session.walker().status().state == hal::WalkState::kStanding; }
  void renew() {
    ASSERT_EQ(refusal("lease", {{"lease", lease}, {"released", 0}, {"age_ns", 0}}), "it was done");
    renewed = session.now();
  }
  /// With the link in order.
  template <class Done>
  bool walk_until(const Done& done, double longest = 60) {
    return pass_until(
        [&] {
          if (session.now() - renewed >= kRenews) renew();
          return done();
        },
        longest);
  }
  void set_off(double x, double y) {
    ++lease;
    renew();
    pass(0.1);
    ASSERT_TRUE(walk_until([&] { return session.status().at_rest && stands(); }));
    ASSERT_TRUE(walk_until(
        [&] {
          return ask("plan_preview", {{"x", x}, {"y", y}}).at("ok").get<bool>();
        },
        5));
    const Json way = ask("plan_preview", {{"x", x}, {"y", y}});
    ASSERT_EQ(refusal("plan_confirm", {{"plan", way.at("plan")}}), "it was done");
    ASSERT_TRUE(walk_until([&] { return !stands(); }))
        << name(session.mission().state()) << ": " << session.mission().reason();
  }
  void lose() {
    ASSERT_TRUE(pass_until([&] { return stands(); }, 10));
    worst = std::max(worst, session.now() - renewed - kNoticed);
    EXPECT_LE(to_seconds(session.now() - renewed), to_seconds(kNoticed + kRests + kTold));
    const Pose2 rests = session.body().stance().base();
    pass(6);
    renew();  // too late: the lease is gone
    pass(4);
    EXPECT_TRUE(stands());
    EXPECT_LT(distance(rests.x, rests.y), 1e-9) << "it went on by itself";
  }

  std::uint32_t lease = 0;
  Time renewed{};
  Duration worst{};  ///< until it was at rest, after the loss was noticed
};

void lose_the_link(int times) {
  Link link;
  ASSERT_TRUE(link.pass_until(MissionState::kWaitGoal));
  link.pass(0.5);
  sim::Dice dice(static_cast<std::uint64_t>(times));
  for (int i = 0; i < times && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE(i);
    link.distance(1.6, 0.4) > link.distance(-0.6, -0.3) ? link.set_off(1.6, 0.4) : link.set_off(-0.6, -0.3);
    const Time moment = link.session.now() + seconds(dice.between(0, 11));
    link.walk_until([&] { return link.session.now() >= moment || link.stands(); });
    link.lose();
  }
  std::printf("link lost at %d moments: at rest at most %.2f s after it was noticed\n", times,
              to_seconds(link.worst));
}

TEST(OperatorLink, LostInAWalkTheRobotRestsAndStaysAtRest) { lose_the_link(4); }

TEST(OperatorLinkSlow, LostAtAHundredMomentsTheRobotRestsAndStaysAtRest) { lose_the_link(100); }

}  // namespace
}  // namespace headway::app
