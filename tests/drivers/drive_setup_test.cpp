// The set-up of a drive, as a table.
#include "drivers/drive_setup.h"

#include <gtest/gtest.h>

#include "tests/drivers/head_bench.h"

namespace headway::drivers {
namespace {

TEST(DriveSetup, HasRoomForEverythingThatADriveCanBeTold) {
  HeadConfig config;
  config.set_points = SetPointMode::kCyclic;
  config.homing.policy = HomingConfig::Policy::kMove;
  config.homing.method = 17;
  testing::HeadBench bench(config);
  ASSERT_TRUE(bench.start());
  EXPECT_EQ(bench.pan.written.size(), SetupTable::kMost);
}

}  // namespace
}  // namespace headway::drivers
