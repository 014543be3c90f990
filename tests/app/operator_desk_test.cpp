// What the operator asks for, done by a simulated robot.
#include "app/operator_desk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/served_robot.h"

namespace headway::app {
namespace {

using runtime::MissionState;
using testing::HasSubstr;

/// From an order to rest, wherever in a walk; its first steps take longest (docs/faults.md) [s].
constexpr double kRests = 2.8;

TEST(OperatorDesk, ShowsAWayFirstAndWalksItOnceItIsConfirmed) {
  Served robot;
  ASSERT_TRUE(robot.pass_until(MissionState::kWaitGoal));
  robot.pass(0.5);
  const Json way = robot.ask("plan_preview", {{"x", 0.5}, {"y", 0.2}});
  ASSERT_TRUE(way.at("ok").get<bool>()) << way;
  EXPECT_NEAR(way.at("metres").get<double>(), 1.3, 0.4);
  EXPECT_GT(way.at("steps").get<int>(), 4);
  EXPECT_GT(way.at("seconds").get<double>(), 4);
  EXPECT_EQ(robot.shown.size(), way.at("way").size());
  robot.pass(3);
  EXPECT_LT(robot.distance(-0.8, 0), 0.02) << "a way that is only shown moves nothing";
  const Json plan{{"plan", way.at("plan")}};
  EXPECT_EQ(robot.refusal("plan_confirm", plan), "it was done");
  EXPECT_TRUE(robot.shown.empty());
  ASSERT_TRUE(robot.pass_until(MissionState::kArrived));
  EXPECT_LT(robot.distance(0.5, 0.2), 0.12);
  EXPECT_THAT(robot.refusal("plan_confirm", plan), HasSubstr("not the newest"));
}

TEST(OperatorDesk, AWayOfAnotherClientOrOfAMinuteAgoIsNotWalked) {
  Served robot;
  ASSERT_TRUE(robot.pass_until(MissionState::kWaitGoal));
  robot.pass(0.5);
  const Json first = robot.ask("plan_preview", {{"x", 0.5}, {"y", 0.2}});
  const Json second = robot.ask("plan_preview", {{"x", 0.4}, {"y", 0.2}});
  EXPECT_THAT(robot.refusal("plan_confirm", {{"plan", first.at("plan")}}), HasSubstr("not the newest"));
  EXPECT_THAT(robot.refusal("plan_confirm", {{"plan", second.at("plan")}}, kOther),
              HasSubstr("not the newest"));
  robot.pass(61);
  EXPECT_THAT(robot.refusal("plan_confirm", {{"plan", second.at("plan")}}), HasSubstr("ago"));
  EXPECT_LT(robot.distance(-0.8, 0), 0.02);
}

TEST(OperatorDesk, SaysWhyThereIsNoWayAndHowNearOneComes) {
  Served robot;
  ASSERT_TRUE(robot.pass_until(MissionState::kWaitGoal));
  robot.pass(0.5);
  EXPECT_THAT(robot.refusal("plan_preview", {{"x", 50}, {"y", 0}}), HasSubstr("outside the floor in use"));
  const Json wall = robot.ask("plan_preview", {{"x", 2.98}, {"y", 0}});
  EXPECT_FALSE(wall.at("ok").get<bool>());
  EXPECT_THAT(wall.at("error").get<std::string>(), HasSubstr("no way there"));
  const Json near = robot.ask("plan_preview", {{"x", 2.98}, {"y", 0}, {"near", true}});
  ASSERT_TRUE(near.at("ok").get<bool>()) << near;
  EXPECT_FALSE(near.at("note").get<std::string>().empty());
}

TEST(OperatorDesk, StopsForGoodAndPausesForAWhile) {
  Served robot;
  ASSERT_TRUE(robot.pass_until(MissionState::kWaitGoal));
  robot.pass(0.5);
  EXPECT_THAT(robot.refusal("pause"), HasSubstr("nothing is walked"));
  EXPECT_THAT(robot.refusal("resume"), HasSubstr("nothing is paused"));
  const Json way = robot.ask("plan_preview", {{"x", 1.2}, {"y", 0}});
  ASSERT_EQ(robot.refusal("plan_confirm", {{"plan", way.at("plan")}}), "it was done");
  ASSERT_TRUE(robot.pass_until([&] { return robot.distance(-0.8, 0) > 0.6; }));
  EXPECT_EQ(robot.refusal("pause"), "it was done");
  robot.pass(kRests);
  EXPECT_TRUE(robot.session.status().at_rest);
  EXPECT_TRUE(robot.status().paused);
  const double there = robot.distance(1.2, 0);
  robot.pass(20);
  EXPECT_NEAR(robot.distance(1.2, 0), there, 1e-3) << "nothing goes on by itself";
  EXPECT_EQ(robot.refusal("resume"), "it was done");
  ASSERT_TRUE(robot.pass_until([&] { return robot.distance(1.2, 0) < there - 0.2; }));
  EXPECT_EQ(robot.refusal("stop"), "it was done");
  robot.pass(kRests);
  EXPECT_TRUE(robot.session.status().at_rest);
  EXPECT_THAT(robot.refusal("resume"), HasSubstr("nothing is paused"));
}

TEST(OperatorDesk, WalksAListOfGoalsAndNoneAfterAStop) {
  Served robot;
  ASSERT_TRUE(robot.pass_until(MissionState::kWaitGoal));
  robot.pass(0.5);
  const Json way = robot.ask("tour", {{"goals", {{0.2, 0.3}, {-0.6, -0.4}, {0.5, 0}}}});
  ASSERT_TRUE(way.at("ok").get<bool>()) << way;
  ASSERT_EQ(robot.refusal("plan_confirm", {{"plan", way.at("plan")}}), "it was done");
  EXPECT_EQ(robot.status().tour_left, 2U);
  ASSERT_TRUE(robot.pass_until([&] { return robot.status().tour_left == 1; }));
  EXPECT_LT(robot.distance(0.2, 0.3), 0.12);
  ASSERT_TRUE(robot.pass_until([&] { return robot.distance(0.2, 0.3) > 0.3; }));
  EXPECT_EQ(robot.refusal("stop"), "it was done");
  EXPECT_EQ(robot.status().tour_left, 0U);
  robot.pass(10);
  const Pose2 rests = robot.session.body().stance().base();
  robot.pass(10);
  EXPECT_LT(robot.distance(rests.x, rests.y), 1e-3);
}

/// On its way to the first of three goals.
struct OnATour : Served {
  OnATour() {
    EXPECT_TRUE(pass_until(MissionState::kWaitGoal));
    pass(0.5);
    const Json way = ask("tour", {{"goals", {{0.2, 0.3}, {-0.6, -0.4}, {0.5, 0}}}});
    EXPECT_EQ(refusal("plan_confirm", {{"plan", way.at("plan")}}), "it was done");
    EXPECT_TRUE(pass_until([&] { return distance(-0.8, 0) > 0.3; }));
  }
  void expect_to_stay() {
    EXPECT_EQ(status().tour_left, 0U);
    pass(kRests);
    const Pose2 rests = session.body().stance().base();
    pass(15);
    EXPECT_LT(distance(rests.x, rests.y), 1e-3);
  }
};

TEST(OperatorDesk, APauseKeepsTheListOfGoals) {
  OnATour robot;
  EXPECT_EQ(robot.refusal("pause"), "it was done");
  robot.pass(kRests);
  EXPECT_EQ(robot.refusal("resume"), "it was done");
  EXPECT_EQ(robot.status().tour_left, 2U);
  ASSERT_TRUE(robot.pass_until([&] { return robot.status().tour_left == 0; }));
  EXPECT_LT(robot.distance(-0.6, -0.4), 0.12);
}

TEST(OperatorDesk, AStopOfAnotherHandEndsTheListThoughTheGoalIsReached) {
  OnATour robot;
  ASSERT_TRUE(robot.pass_until([&] { return robot.distance(0.2, 0.3) < 0.15; }));
  robot.session.line().stay();
  robot.pass(0.1);
  robot.expect_to_stay();
}

TEST(OperatorDesk, WhoGivesControlUpStopsTheRobot) {
  OnATour robot;
  ASSERT_EQ(robot.refusal("lease", {{"lease", 2}, {"released", 1}, {"age_ns", 0}}), "it was done")
      << "another took it at once";
  robot.expect_to_stay();
}

TEST(OperatorDesk, APauseIsOverWhenAnotherHandSendsTheRobotOn) {
  OnATour robot;
  EXPECT_EQ(robot.refusal("pause"), "it was done");
  robot.pass(kRests);
  EXPECT_TRUE(robot.status().paused);
  robot.session.line().go({{0.5, 0}, std::nullopt});
  robot.pass(3);
  EXPECT_FALSE(robot.status().paused);
  EXPECT_EQ(robot.status().tour_left, 0U);
}

TEST(OperatorDesk, LooksWhereItIsToldAtRestOnly) {
  Served robot;
  ASSERT_TRUE(robot.pass_until(MissionState::kLookAround));
  EXPECT_THAT(robot.refusal("look", {{"pan", 0.3}, {"tilt", 0.4}}), HasSubstr("stop it first"));
  ASSERT_TRUE(robot.pass_until(MissionState::kWaitGoal));
  robot.pass(0.5);
  EXPECT_THAT(robot.refusal("look", {{"pan", 9}, {"tilt", 0.4}}), HasSubstr("expected a number from"));
  EXPECT_EQ(robot.refusal("look", {{"pan", 0.3}, {"tilt", 0.4}}), "it was done");
  robot.pass(2);
  EXPECT_NEAR(robot.session.status().angles.pan, 0.3, 0.01);
  EXPECT_NEAR(robot.session.status().angles.tilt, 0.4, 0.01);
  const std::size_t views = robot.session.mission().views_taken();
  EXPECT_EQ(robot.refusal("look_around"), "it was done");
  robot.pass(1);
  EXPECT_TRUE(robot.pass_until(MissionState::kWaitGoal));
  EXPECT_GE(robot.session.mission().views_taken(), views);
}

TEST(OperatorDesk, ProposesWhereToLookNextAndGoesHome) {
  Served robot;
  ASSERT_TRUE(robot.pass_until(MissionState::kWaitGoal));
  robot.pass(0.5);
  Json next = robot.ask("explore_preview");
  int looks = 0;
  for (; next.at("ok").get<bool>() && looks < 6; ++looks) {
    EXPECT_GT(next.at("view").at("gain").get<double>(), 0);
    ASSERT_EQ(robot.refusal("plan_confirm", {{"plan", next.at("plan")}}), "it was done");
    EXPECT_TRUE(robot.status().exploring);
    robot.pass(1);
    robot.pass_until([&] {
      const MissionState state = robot.session.status().state;
      return state == MissionState::kArrived || state == MissionState::kWaitGoal;
    });
    robot.pass(1);
    next = robot.ask("explore_preview");
  }
  EXPECT_GT(looks, 0);
  const Json home = robot.ask("go_home");
  ASSERT_TRUE(home.at("ok").get<bool>()) << home;
  ASSERT_EQ(robot.refusal("plan_confirm", {{"plan", home.at("plan")}}), "it was done");
  robot.pass(1);
  ASSERT_TRUE(robot.pass_until(MissionState::kArrived));
  EXPECT_LT(robot.distance(-0.8, 0), 0.12);
}

TEST(OperatorDesk, SaysWhatIsWrongWithAQuestion) {
  Served robot;
  EXPECT_THAT(robot.refusal("dance"), HasSubstr("no such service"));
  EXPECT_THAT(robot.refusal("plan_preview", {{"x", 1}}), HasSubstr("y: is missing"));
  EXPECT_THAT(robot.refusal("plan_preview", {{"x", "1"}, {"y", 0}}), HasSubstr("x: expected a number"));
  EXPECT_THAT(robot.refusal("plan_preview", {{"x", 1}, {"y", 0}, {"z", 0}}), HasSubstr("z: no such key"));
  EXPECT_THAT(robot.refusal("plan_preview", {{"x", 0}, {"y", 0}}), HasSubstr("not known yet"));
  EXPECT_THAT(robot.refusal("tour", {{"goals", Json::array()}}), HasSubstr("1 to 50"));
  EXPECT_THAT(robot.refusal("tour", {{"goals", {{1}}}}), HasSubstr("goals[0]"));
  EXPECT_THAT(robot.refusal("record", {{"on", true}}), HasSubstr("nothing is recorded"));
  EXPECT_THAT(robot.refusal("plan_confirm", {{"plan", -1}}), HasSubstr("plan: expected"));
  EXPECT_THAT(robot.desk.answer(1, "pause", "[", {}, {}), HasSubstr("JSON object"));
  EXPECT_EQ(robot.desk.answer(1, "stop", "[", {}, {}), R"({"ok":true})") << "whatever else is said";
}

}  // namespace
}  // namespace headway::app
