// The orderly end of a head: its drives hold, and wait for nobody.
#include <gtest/gtest.h>

#include "tests/drivers/head_bench.h"

namespace headway::drivers {
namespace {

using hal::HeadHealth;
using std::chrono::milliseconds;
using testing::HeadBench;
using testing::ScriptedDrive;
using State = ScriptedDrive::State;

class LeavingHead : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(bench.start()); }
  HeadBench bench;
};

TEST_F(LeavingHead, LetsItsDrivesHoldAndWaitForNobody) {
  bench.head.command({0.7, 0});
  bench.run(milliseconds(200));
  bench.head.leave();
  ASSERT_TRUE(bench.run_until([&] { return bench.head.has_left(); }, milliseconds(200)));
  for (ScriptedDrive* drive : {&bench.pan, &bench.tilt}) {
    EXPECT_EQ(drive->state, State::kQuickStop);
    EXPECT_EQ((drive->objects[{0x1016, 1}]), 0u);
  }
  const auto stood = bench.pan.position;
  bench.pan.boot(bench.now);
  bench.run(seconds(1));
  EXPECT_EQ(bench.pan.position, stood) << "nothing is begun anew";
  EXPECT_TRUE(bench.head.has_left());
  EXPECT_EQ(bench.head.pan().quick_stops, 0u) << "this one was ordered";
}

TEST_F(LeavingHead, DoesNotWaitForADriveThatIsGoneNorForOneThatRefuses) {
  bench.pan.mute_heartbeat = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(1)));
  bench.tilt.refuses = ScriptedDrive::Key{0x1016, 1};
  bench.head.leave();
  EXPECT_TRUE(bench.run_until([&] { return bench.head.has_left(); }, milliseconds(200)));
}

}  // namespace
}  // namespace headway::drivers
