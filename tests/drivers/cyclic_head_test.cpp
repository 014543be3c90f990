// The head led cyclically: a target with every SYNC, on a way that is made here.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/drivers/head_bench.h"
#include "tests/drivers/noise.h"

namespace headway::drivers {
namespace {

using hal::HeadHealth;
using std::chrono::milliseconds;
using testing::HeadBench;
using testing::ScriptedDrive;

HeadConfig cyclic() {
  HeadConfig config;
  config.set_points = SetPointMode::kCyclic;
  return config;
}

class CyclicHead : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(bench.start()); }
  HeadBench bench{cyclic()};
};

/// The largest step between targets, and the largest change of such steps [0.001 deg].
struct Roughness {
  int step = 0, change = 0;
  explicit Roughness(const std::vector<std::int32_t>& targets) {
    for (std::size_t i = 1; i < targets.size(); ++i) {
      const int now = targets[i] - targets[i - 1], before = i > 1 ? targets[i - 1] - targets[i - 2] : 0;
      step = std::max(step, std::abs(now));
      change = std::max(change, std::abs(now - before));
    }
  }
};
// 1 rad/s and 4 rad/s^2, 20 ms apart, each target rounded.
constexpr int kLargestStep = 1146 + 1, kLargestChange = 92 + 2;

TEST_F(CyclicHead, IsSetUpToTakeATargetFromEachSyncToTheNext) {
  for (ScriptedDrive* drive : {&bench.pan, &bench.tilt}) {
    EXPECT_EQ((drive->objects[{0x1400, 2}]), 1u);
    EXPECT_EQ((drive->objects[{0x60C2, 1}]), 20u);
    EXPECT_EQ((drive->objects[{0x60C2, 2}]), 0xFDu);
  }
  bench.bus.sent.clear();
  bench.run(seconds(1));
  EXPECT_EQ(bench.bus.sent_with(0x080).size(), 50u);
  EXPECT_EQ(bench.bus.sent_with(0x211).size(), 50u);
  EXPECT_TRUE(bench.pan.set_points.empty());
}

TEST_F(CyclicHead, TurnsWhereItIsToldWithinVelocityAndAcceleration) {
  bench.head.command({0.5, -0.2});
  EXPECT_TRUE(bench.head.state().moving);
  ASSERT_TRUE(bench.run_until([&] { return !bench.head.state().moving; }, seconds(3)));
  EXPECT_NEAR(bench.head.state().position.pan, 0.5, 1.8e-3);
  bench.run(milliseconds(60));
  EXPECT_EQ(bench.pan.position, 28648);
  EXPECT_EQ(bench.tilt.position, -11459);
  const Roughness pan(bench.pan.cyclic_targets);
  EXPECT_GT(pan.step, 1100) << "as fast as it may";
  EXPECT_LE(pan.step, kLargestStep);
  EXPECT_LE(pan.change, kLargestChange);
}

TEST_F(CyclicHead, BrakesAndStandsWhileTheOtherDriveIsAtFaultAndStaysThereAfterwards) {
  bench.head.command({0.7, 0.7});
  bench.run(milliseconds(400));
  bench.pan.emergency(0x8611, bench.now);
  bench.run(milliseconds(400));
  ASSERT_EQ(bench.head.state().health, HeadHealth::kFault);
  const auto pan = bench.pan.position, tilt = bench.tilt.position;
  EXPECT_LT(tilt, 35000);
  bench.run(seconds(1));
  EXPECT_EQ(bench.pan.position, pan);
  EXPECT_EQ(bench.tilt.position, tilt);
  EXPECT_LE(Roughness(bench.tilt.cyclic_targets).change, kLargestChange);
  bench.head.recover();
  ASSERT_TRUE(bench.start());
  bench.run(seconds(1));
  EXPECT_EQ(bench.tilt.position, tilt);
}

TEST_F(CyclicHead, GoesOnWithoutAJumpAfterTheBusWasFull) {
  bench.head.command({0.7, 0});
  bench.run(milliseconds(400));
  bench.bus.full = true;
  bench.run(milliseconds(250));
  bench.bus.full = false;
  bench.run(seconds(2));
  EXPECT_LE(Roughness(bench.pan.cyclic_targets).step, kLargestStep);
  EXPECT_EQ(bench.pan.position, 40107);
}

TEST_F(CyclicHead, StartsFromWhereItWasPushedToWhileItHadNoTorque) {
  bench.head.command({0.3, 0});
  bench.run(seconds(1));
  bench.pan.position = -12345;
  bench.pan.boot(bench.now);
  bench.cycle();
  ASSERT_TRUE(bench.start());
  bench.run(seconds(1));
  EXPECT_EQ(bench.pan.largest_start, 0);
  EXPECT_EQ(bench.pan.position, -12345);
}

TEST_F(CyclicHead, GoesOnFromWhereTheJointIsWhenADriveHasNotFollowedForAWhile) {
  bench.head.command({0.7, 0});
  bench.run(milliseconds(300));
  bench.pan.never_acknowledges = true;
  bench.run(milliseconds(200));
  const auto stood = bench.pan.position;
  ASSERT_LT(stood, 30000);
  bench.pan.never_acknowledges = false;
  bench.pan.cyclic_targets.clear();
  bench.run(seconds(2));
  EXPECT_EQ(bench.pan.cyclic_targets.front(), stood);
  EXPECT_EQ(bench.pan.largest_start, 0);
  EXPECT_LE(Roughness(bench.pan.cyclic_targets).change, kLargestChange);
  EXPECT_EQ(bench.pan.position, 40107);
}

TEST_F(CyclicHead, BeginsItsWayOnlyWhenADriveFollows) {
  bench.pan.never_acknowledges = true;
  bench.pan.boot(bench.now);
  bench.pan.position = -12345;
  bench.cycle();
  ASSERT_TRUE(bench.run_until([&] { return bench.head.pan().phase == DrivePhase::kRunning; }, seconds(3)));
  bench.pan.position = 2000;  // it gives way a little
  bench.run(milliseconds(200));
  bench.pan.never_acknowledges = false;
  ASSERT_TRUE(bench.start());
  bench.run(seconds(1));
  EXPECT_EQ(bench.pan.largest_start, 0);
  EXPECT_LE(bench.pan.largest_step, kLargestStep);
}

TEST_F(CyclicHead, BrakesAndStandsWhileADriveIsNotHeardAndThenGoesOn) {
  bench.head.command({0.7, 0});
  bench.run(milliseconds(300));
  bench.pan.mute_position = true;
  bench.run(milliseconds(600));
  ASSERT_EQ(bench.head.state().health, HeadHealth::kDegraded);
  const auto stood = bench.pan.cyclic_targets.back();
  EXPECT_LT(stood, 35000);
  bench.run(milliseconds(600));
  EXPECT_EQ(bench.pan.cyclic_targets.back(), stood);
  bench.pan.mute_position = false;
  bench.run(seconds(2));
  EXPECT_EQ(bench.pan.position, 40107);
  EXPECT_LE(Roughness(bench.pan.cyclic_targets).change, kLargestChange);
}

/// A drive makes each way in 20 ms.
TEST_F(CyclicHead, LeavesADriveItsTimeForEachTargetHoweverLateTheOneBeforeWas) {
  for (const int late : {5, 10, 15, 25}) {
    const auto syncs = [&] { return bench.bus.sent_with(0x080); };
    ASSERT_TRUE(bench.run_until([&] { return syncs().back().stamp == bench.now; }, milliseconds(50)));
    bench.run(milliseconds(15));
    bench.bus.full = true;
    bench.run(milliseconds(late));
    bench.bus.full = false;
    bench.run(milliseconds(100));
    const auto sent = syncs();
    for (std::size_t i = 1; i < sent.size(); ++i)
      ASSERT_GE(sent[i].stamp - sent[i - 1].stamp, milliseconds(20)) << "after " << late << " ms";
  }
}

TEST_F(CyclicHead, KeepsThePaceOfSyncWhenItsLoopIsALittleUnsteady) {
  bench.bus.sent.clear();
  for (int i = 0; i < 400; ++i) {
    bench.now += std::chrono::microseconds(i % 2 == 0 ? 300 : -300);
    bench.cycle();
  }
  EXPECT_NEAR(static_cast<double>(bench.bus.sent_with(0x080).size()), 100, 2);
}

/// Where a drive wants to be that goes evenly to each target, in a period from its SYNC on, and stays there.
class Interpolator {
 public:
  /// Its velocity from now on [0.001 deg per period].
  double take(std::int32_t target, Time now) {
    const double part = std::min(to_seconds(now - since_) / 0.02, 1.0);
    from_ += part * (target_ - from_);
    target_ = target;
    since_ = now;
    return std::abs(target_ - from_);
  }

 private:
  double from_ = 0, target_ = 0;
  Time since_{};
};

RC_GTEST_PROP(CyclicHeadUnsteady, NeverLeadsADriveFasterThanItMayHoweverUnsteadySyncIs, ()) {
  HeadBench bench(cyclic());
  RC_ASSERT(bench.start());
  Interpolator drive;
  std::size_t taken = bench.pan.cyclic_targets.size();
  double fastest = 0;
  bench.head.command({0.7, 0});
  const int most = *rc::gen::inRange(0, 2400);  // [us]
  Time steady = bench.now;
  for (int i = 0; i < 500; ++i) {
    steady += testing::kBusCycle;
    const auto late = std::chrono::microseconds(*rc::gen::inRange(0, most + 1));
    bench.now = steady + late - testing::kBusCycle;
    bench.cycle();
    for (; taken < bench.pan.cyclic_targets.size(); ++taken)
      fastest = std::max(fastest, drive.take(bench.pan.cyclic_targets[taken], bench.now));
  }
  RC_ASSERT(fastest <= kLargestStep + 1);
  RC_ASSERT(fastest > 1100);
  RC_ASSERT(bench.pan.cyclic_targets.back() == 40107);
}

TEST_F(CyclicHead, FaultsWhenADriveDoesNotFollow) {
  bench.pan.never_acknowledges = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(1)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kSetPointTimedOut);
}

TEST(CyclicHeadStart, ComesInsideOnTheRampFromALittleOutside) {
  HeadBench bench(cyclic());
  bench.pan.position = 45400;
  ASSERT_TRUE(bench.start());
  bench.run(seconds(1));
  EXPECT_EQ(bench.pan.position, 45000);
  EXPECT_EQ(*std::ranges::max_element(bench.pan.cyclic_targets), 45400);
  EXPECT_LE(Roughness(bench.pan.cyclic_targets).change, kLargestChange);
}

TEST(CyclicHeadStart, IsRefusedWithoutTorqueFromFarOutside) {
  HeadBench bench(cyclic());
  bench.pan.position = 50000;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(2)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kOutsideLimits);
  EXPECT_TRUE(bench.pan.states.empty());
}

TEST(CyclicHeadStart, IsRefusedFromFarOutsideEvenWhereADriveIsEnabledAlready) {
  HeadBench bench(cyclic());
  ASSERT_TRUE(bench.start());
  bench.pan.emergency(0x8611, bench.now);
  bench.run(milliseconds(100));
  ASSERT_EQ(bench.head.pan().failure, DriveFailure::kEmergency);
  bench.head.recover();
  bench.pan.target = bench.pan.position = 50000;
  const auto refused = [&] { return bench.head.pan().failure == DriveFailure::kOutsideLimits; };
  ASSERT_TRUE(bench.run_until(refused, seconds(3)));
  bench.run(seconds(1));
  EXPECT_EQ(bench.pan.position, 50000) << "it is not led back";
}

RC_GTEST_PROP(CyclicHeadCommands, KeepLimitsVelocityAndAccelerationOnTheWire, ()) {
  HeadBench bench(cyclic());
  RC_ASSERT(bench.start());
  const int count = *rc::gen::inRange(1, 10);
  for (int i = 0; i < count; ++i) {
    bench.head.command({*rc::gen::inRange(-8000, 8000) * 1e-3, *rc::gen::inRange(-8000, 8000) * 1e-3});
    bench.run(milliseconds(5 * *rc::gen::inRange(1, 200)));
  }
  for (const std::int32_t target : bench.pan.cyclic_targets) RC_ASSERT(std::abs(target) <= 45000);
  for (const std::int32_t target : bench.tilt.cyclic_targets) RC_ASSERT(target >= -30000 && target <= 45000);
  for (ScriptedDrive* drive : {&bench.pan, &bench.tilt}) {
    const Roughness roughness(drive->cyclic_targets);
    RC_ASSERT(roughness.step <= kLargestStep);
    RC_ASSERT(roughness.change <= kLargestChange);
  }
}

RC_GTEST_PROP(CyclicHeadActivation, NeverJumpsWhateverHappensOnTheBus, ()) {
  HeadBench bench(cyclic());
  bench.pan.position = *rc::gen::inRange(-44000, 44000);
  bench.tilt.position = *rc::gen::inRange(-29000, 44000);
  RC_ASSERT(bench.start());
  const unsigned loss = *rc::gen::inRange(0u, 10u);
  testing::Noise noise(*rc::gen::inRange(1u, 1u << 30));
  // A drive that misses a SYNC makes up for it in the next, whoever leads it.
  bench.to_drives = [&](hal::CanFrame& frame) { return frame.id == 0x080 || noise.percent() >= loss; };
  bool heard = true;
  bench.to_head = [&](hal::CanFrame& frame) {
    // What a drive says of one SYNC comes whole or not at all.
    if ((frame.id & 0x780) != 0x280) heard = noise.percent() >= loss;
    return heard;
  };
  for (int i = 0; i < 20; ++i) {
    bench.head.command({noise.percent() * 0.016 - 0.8, noise.percent() * 0.016 - 0.8});
    bench.run(milliseconds(5 * (noise.percent() + 1)));
    if (noise.percent() < 20) {
      bench.pan.never_acknowledges = true;
      bench.run(milliseconds(100));
      bench.pan.position += static_cast<std::int32_t>(noise.percent()) * 20 - 1000;  // it gives way
      bench.run(milliseconds(250));
      bench.pan.never_acknowledges = false;
    }
    if (noise.percent() < 20) {
      bench.pan.boot(bench.now);
      bench.pan.position = static_cast<std::int32_t>(noise.percent()) * 400 - 20000;  // pushed without torque
    }
    if (noise.percent() < 10) bench.tilt.quick_stop();
    if (noise.percent() < 10) bench.tilt.fault();
    if (noise.percent() < 20) bench.head.recover();
  }
  for (ScriptedDrive* drive : {&bench.pan, &bench.tilt}) {
    RC_ASSERT(drive->largest_start <= kLargestStep);  // the targets before it may have got lost
    RC_ASSERT(drive->largest_step <= kLargestStep);
  }
  bench.to_head = bench.to_drives = [](hal::CanFrame&) { return true; };
  bench.run(seconds(2));
  bench.head.recover();
  RC_ASSERT(bench.start());
}

}  // namespace
}  // namespace headway::drivers
