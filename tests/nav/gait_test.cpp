#include "nav/walking/gait.h"

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "hal/error.h"

namespace headway::nav {
namespace {

TEST(GaitLimits, RefuseWhatNoRobotCouldDo) {
  GaitLimits{}.validate();
  const auto message = [](const GaitLimits& g) {
    try {
      g.validate();
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  GaitLimits crossing, rushing;
  crossing.inward = 0.1;
  EXPECT_NE(message(crossing).find("inward"), std::string::npos);
  rushing.step_duration = seconds(0.05);
  EXPECT_NE(message(rushing).find("step_duration"), std::string::npos);
  GaitLimits short_over;
  short_over.over.height = 0.06;
  short_over.over.forward = 0.1;
  EXPECT_NE(message(short_over).find("step_over: forward"), std::string::npos) << message(short_over);
  short_over.over.height = 0;
  EXPECT_EQ(message(short_over), "") << "there are no such steps";
}

TEST(GaitLimits, AllowOnlyStepsThatThePatternTakes) {
  int allowed = 0;
  for (int ms = 100; ms <= 1700; ms += 10) {
    GaitLimits gait;
    gait.step_duration = std::chrono::milliseconds(ms);
    try {
      gait.validate();
    } catch (const InputError&) {
      continue;
    }
    ++allowed;
    EXPECT_NO_THROW(walking_config(gait).validate()) << ms << " ms";
  }
  EXPECT_EQ(allowed, 131) << "from 0.25 s to 1.55 s";
}

TEST(GaitLimits, NeverTurnMoreThanTheyMayOnTheWire) {
  const GaitLimits gait;
  EXPECT_NEAR(gait.yaw_on_the_wire(), 0.086, 1e-12);
  EXPECT_NEAR(gait.turn_seconds(std::numbers::pi / 4), 7.2, 1e-9);
  EXPECT_NEAR(gait.forward_seconds(1), 4, 1e-9);
  EXPECT_NEAR(gait.sideway_seconds(0.05), 1.6, 1e-9);
}

}  // namespace
}  // namespace headway::nav
