// Robots among things that move, and whether the judges of their answers notice what they should.
#include <gtest/gtest.h>

#include "app/moving_totals.h"
#include "app/sim_outputs.h"
#include "app/sim_session.h"
#include "sim_hal/random_movers.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"

namespace headway::app {
namespace {

const std::filesystem::path kTree = source_dir();

Robot hrp2() { return read_robot(kTree / "config/hrp2/robot.yaml"); }
sim::World moving_box() { return sim::read_world(kTree / "config/worlds/moving_box.yaml"); }

SimOptions range_mode(std::uint64_t seed = 1) {
  SimOptions options;
  options.range_mode = true;
  options.seed = seed;
  return options;
}

/// Walks through worlds of its own making, and what must hold in each.
struct Worlds {
  MovingTotals totals;
  int arrived = 0;

  Worlds(std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t seed = first; seed <= last; ++seed) {
      SimSession session(hrp2(), sim::random_moving_world(seed), range_mode(seed));
      const SimOutcome outcome = session.run();
      EXPECT_FALSE(outcome.collision || outcome.fallen) << seed << ": " << outcome.reason;
      EXPECT_GT(session.body_mask().samples(), 500U) << seed;
      arrived += outcome.arrived;
      totals.add(session);
    }
    EXPECT_EQ(totals.report()["seen_late"], 0) << totals.line();
    EXPECT_GE(totals.report()["replanned_share"], 0.5) << totals.line();
    EXPECT_GE(totals.report()["answering"].get<double>(), 0.3 * static_cast<double>(last - first + 1))
        << totals.line();
    EXPECT_LE(totals.report()["frame_periods_p99"], 1) << totals.line();
  }
};

TEST(MovingCampaign, WalksAroundWhatComesOntoTheWay) {
  const Worlds worlds(1009, 1010);
  EXPECT_EQ(worlds.arrived, 2);
  EXPECT_EQ(worlds.totals.report()["outside_mask"], 0) << worlds.totals.line();
}

TEST(MovingCampaignSlow, TouchesNothingInTwentyMovingWorldsAndArrivesInNearlyAll) {
  EXPECT_GE(Worlds(2001, 2020).arrived, 18);
}

TEST(ReactionCheckSlow, FindsTheAnswersOfASlowRobot) {
  const auto slowest = [](double plan_seconds) {
    Robot robot = hrp2();
    robot.simulation.charge.plan = seconds(plan_seconds);
    SimSession session(robot, sim::random_moving_world(1009), range_mode(1009));
    session.run();
    double periods = 0;
    for (const ReactionCheck::Reaction& r : session.reactions().reactions())
      if (!r.left) periods = std::max(periods, to_seconds(r.handed - r.shown) * robot.simulation.frame_rate);
    return periods;
  };
  const double quick = slowest(0.015);
  EXPECT_GT(quick, 0.62) << "the stages take 62 of 100 ms";
  EXPECT_GT(slowest(0.2), 2.4) << "247 ms";
}

TEST(ReactionCheckSlow, SeesNothingMoveWhereNothingMoves) {
  sim::World world = moving_box();
  world.moving.clear();
  SimSession session(hrp2(), world, range_mode());
  session.run();
  EXPECT_TRUE(session.reactions().sightings().empty());
  EXPECT_TRUE(session.reactions().reactions().empty());
}

TEST(BodyMaskCheckSlow, FindsABodyThatIsBesideItsPath) {
  const auto outside = [](double yaw_per_step, bool localise) {
    Robot robot = hrp2();
    robot.simulation.body.yaw_per_step = yaw_per_step;
    SimOptions options = range_mode();
    options.localise = localise;
    sim::World world = moving_box();
    world.moving.clear();
    SimSession session(robot, world, options);
    session.run();
    EXPECT_GT(session.body_mask().samples(), 500U);
    return session.body_mask().outside();
  };
  EXPECT_EQ(outside(0, true), 0U);
  EXPECT_GT(outside(0.01, false), 0U) << "swerves by half a metre, and does not know";
}

}  // namespace
}  // namespace headway::app
