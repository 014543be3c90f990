#include "app/patrol.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/world_map.h"
#include "tests/source_dir/source_dir.h"

namespace headway::app {
namespace {

/// So many laps that arrive, each `heap` bytes heavier and `error` metres farther off than the one before.
std::vector<Lap> laps_of(std::size_t count, std::size_t heap, double error) {
  std::vector<Lap> laps(count);
  for (std::size_t i = 0; i < count; ++i) {
    laps[i].outcome.arrived = true;
    laps[i].seconds = 100;
    laps[i].outcome.map_error = 0.01 + error * static_cast<double>(i);
    laps[i].after = {50'000'000 + heap * i, 90'000'000, 7};
  }
  return laps;
}

std::string complaints(const std::vector<Lap>& laps) {
  std::string all;
  for (const std::string& line : endurance_of(laps).complaints()) all += line + "\n";
  return all;
}

TEST(Patrol, FindsNothingWhereNothingGrows) { EXPECT_EQ(complaints(laps_of(40, 0, 0)), ""); }

TEST(Patrol, FindsAHeapThatGrowsALittleWithEachLap) {
  EXPECT_NE(complaints(laps_of(40, 104'858, 0)).find("the heap grew by 2"), std::string::npos);
}

TEST(Patrol, ForgivesWhatGrowsInTheFirstQuarterOnly) {
  auto laps = laps_of(40, 0, 0);
  for (std::size_t i = 0; i < 10; ++i) laps[i].after.heap = 1'000'000 * i;
  EXPECT_EQ(complaints(laps), "");
}

TEST(Patrol, FindsAMapThatDrifts) {
  EXPECT_NE(complaints(laps_of(40, 0, 0.002)).find("the map's error grew by 0.0"), std::string::npos);
}

TEST(Patrol, FindsDescriptorsThatStayOpen) {
  auto laps = laps_of(40, 0, 0);
  laps[30].after.descriptors = 8;
  EXPECT_EQ(complaints(laps), "1 descriptors more are open\n");
}

TEST(Patrol, FindsLapsThatDidNotArrive) {
  auto laps = laps_of(40, 0, 0);
  laps[3].outcome.arrived = false;
  EXPECT_EQ(complaints(laps), "1 of 40 laps did not end at their goal\n");
}

TEST(Patrol, SaysWhenThereAreTooFewLapsToTell) {
  EXPECT_NE(complaints(laps_of(3, 0, 0)), "");
  EXPECT_NE(complaints({}), "");
}

TEST(Patrol, KnowsWhatTheProgramHolds) {
  const Holdings before = holdings_now();
  const int open = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  std::vector<char> much(8 << 20, 'x');
  const Holdings with = holdings_now();
  EXPECT_EQ(with.descriptors, before.descriptors + 1);
  EXPECT_GE(with.heap, before.heap + much.size());
  EXPECT_GT(with.resident, before.resident + much.size() / 2);
  ::close(open);
  EXPECT_EQ(holdings_now().descriptors, before.descriptors);
}

TEST(PatrolSlow, GoesToAndFroAndHoldsNoMoreThanBefore) {
  Robot robot = read_robot(source_dir() / "config/hrp2/robot.yaml");
  robot.simulation.frame_rate = 5;
  sim::World world;
  world.name = "empty room";
  world.floor = {{0.5, 0}, {5, 4}};
  sim::add_room(world, {0.5, 0}, {5, 4}, 2.2, 0);
  const std::vector<nav::Goal> goals{{{0.7, 0.1}, {}}, {{-0.4, 0}, {}}};
  SimOptions options;
  options.range_mode = true;
  options.goal = goals.front();
  SimSession session(robot, world, options);
  const auto laps = patrol(session, goals, seconds(400), [](const Lap&) {});
  ASSERT_GE(laps.size(), 8u);
  EXPECT_EQ(complaints(laps), "");
  // No cycle more or less than time has passed.
  EXPECT_EQ(session.bus_loop().counters().cycles,
            static_cast<std::uint64_t>(session.now().time_since_epoch() / sim::SimRobot::kPeriod));
}

}  // namespace
}  // namespace headway::app
