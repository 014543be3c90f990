#include "drivers/cia402_head.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/angle.h"
#include "hal/error.h"
#include "tests/drivers/head_bench.h"
#include "tests/drivers/noise.h"

namespace headway::drivers {
namespace {

using hal::HeadHealth;
using ::testing::Each;
using ::testing::ElementsAre;
using testing::HeadBench;
using testing::ScriptedDrive;
using State = ScriptedDrive::State;
using std::chrono::milliseconds;

class RunningHead : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(bench.start()); }
  void fault_and_check(DriveFailure why) {
    EXPECT_EQ(bench.head.state().health, HeadHealth::kFault);
    EXPECT_EQ(bench.head.pan().failure, why);
  }
  HeadBench bench;
};

// --- starting ---

TEST(HeadStart, BeginsWithPreOperationalAndEndsReady) {
  HeadBench bench;
  EXPECT_EQ(bench.head.state().health, HeadHealth::kStarting);
  EXPECT_TRUE(bench.run_until(HeadHealth::kReady, seconds(2)));
  const auto orders = bench.bus.sent_with(0x000);
  ASSERT_GE(orders.size(), 4u);
  EXPECT_EQ(orders[0].data[0], 0x80);  // enter pre-operational, each node
  EXPECT_EQ(orders[0].data[1], 0x11);
  EXPECT_EQ(orders[1].data[1], 0x12);
  EXPECT_EQ(orders.back().data[0], 0x01);
}

TEST(HeadStart, WritesWhatTheContractListsIntoBothDrives) {
  HeadBench bench;
  ASSERT_TRUE(bench.start());
  for (ScriptedDrive* drive : {&bench.pan, &bench.tilt}) {
    auto& o = drive->objects;
    EXPECT_EQ((o[{0x1017, 0}]), 100u);
    EXPECT_EQ((o[{0x1016, 1}]), 0x0001012Cu);
    EXPECT_EQ((o[{0x6007, 0}]), 3u);
    EXPECT_EQ((o[{0x605A, 0}]), 6u);
    EXPECT_EQ((o[{0x605E, 0}]), 2u);
    EXPECT_EQ((o[{0x60A8, 0}]), 0xFD410000u);
    EXPECT_EQ((o[{0x6081, 0}]), 57296u);  // 1 rad/s
    EXPECT_EQ((o[{0x6083, 0}]), (o[{0x6084, 0}]));
    EXPECT_EQ((o[{0x1400, 1}]), 0x200u + drive->node);
    EXPECT_EQ((o[{0x1400, 2}]), 255u);
    EXPECT_EQ((o[{0x1600, 1}]), 0x60400010u);
    EXPECT_EQ((o[{0x1600, 2}]), 0x60600008u);
    EXPECT_EQ((o[{0x1600, 3}]), 0x607A0020u);
    EXPECT_EQ((o[{0x1800, 1}]), 0x40000180u + drive->node);
    EXPECT_EQ((o[{0x1800, 2}]), 1u);
    EXPECT_EQ((o[{0x1801, 1}]), 0x40000280u + drive->node);
    for (const std::uint16_t index : std::initializer_list<std::uint16_t>{0x6065, 0x6066, 0x6085})
      EXPECT_GT((o[{index, 0}]), 0u);
  }
  EXPECT_EQ(static_cast<std::int32_t>(bench.pan.objects[{0x607D, 1}]), -45000);
  EXPECT_EQ(static_cast<std::int32_t>(bench.pan.objects[{0x607D, 2}]), 45000);
  EXPECT_EQ(static_cast<std::int32_t>(bench.tilt.objects[{0x607D, 1}]), -30000);
  EXPECT_EQ(static_cast<std::int32_t>(bench.tilt.objects[{0x607D, 2}]), 45000);
}

TEST(HeadStart, GoesThroughTheStatesOneByOne) {
  HeadBench bench;
  ASSERT_TRUE(bench.start());
  EXPECT_THAT(bench.pan.states, ElementsAre(State::kReady, State::kOn, State::kEnabled));
  EXPECT_THAT(bench.tilt.states, ElementsAre(State::kReady, State::kOn, State::kEnabled));
}

TEST(HeadStart, FirstTellsTheDrivesToStayWhereTheyAre) {
  HeadBench bench;
  bench.pan.position = 12345;
  bench.tilt.position = -6789;
  ASSERT_TRUE(bench.start());
  bench.run(seconds(1));
  EXPECT_THAT(bench.pan.set_points, ElementsAre(12345));
  EXPECT_THAT(bench.tilt.set_points, ElementsAre(-6789));
  EXPECT_EQ(bench.pan.position, 12345);
  for (const auto& frame : bench.bus.sent_with(0x211)) {
    EXPECT_NEAR(hal::bus::DriveCommand::unpack(frame)->target_deg, 12.345, 1e-9);
  }
  EXPECT_NEAR(bench.head.state().position.pan, 12.345 * kDegree, 1e-9);
  EXPECT_NEAR(bench.head.state().target.tilt, -6.789 * kDegree, 1e-9);
  EXPECT_FALSE(bench.head.state().moving);
}

TEST(HeadStart, ComesInsideTheLimitsWhenItBeginsOutside) {
  HeadBench bench;
  bench.pan.position = 50000;
  ASSERT_TRUE(bench.start());
  EXPECT_THAT(bench.pan.set_points, ElementsAre(45000));
}

TEST(HeadStart, IsRefusedFromFarOutsideTheLimitsWhereItMayNotComeInside) {
  HeadConfig config;
  config.may_come_inside = false;
  HeadBench bench(config);
  bench.pan.position = 50000;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(3)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kOutsideLimits);
  bench.run(seconds(2));
  EXPECT_EQ(bench.pan.position, 50000);
}

TEST(HeadStart, IgnoresCommandsUntilReady) {
  HeadBench bench;
  while (bench.head.state().health != HeadHealth::kReady) {
    bench.head.command({0.3, 0.3});
    bench.cycle();
    ASSERT_LT(bench.now, at_seconds(105));
  }
  bench.run(seconds(1));
  EXPECT_THAT(bench.pan.set_points, Each(0));
}

TEST(HeadStart, TriesAnUnansweredObjectThreeTimesHalfASecondApart) {
  HeadBench bench;
  bench.pan.mute_sdo = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(3)));
  EXPECT_EQ(bench.pan.sdo_requests, 3);
  const auto tries = bench.bus.sent_with(0x611);
  EXPECT_EQ(tries[1].stamp - tries[0].stamp, milliseconds(500));
  EXPECT_EQ(tries[2].stamp - tries[1].stamp, milliseconds(500));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kSetupTimedOut);
  EXPECT_EQ(bench.head.pan().object.index, 0x1017);
  EXPECT_EQ(bench.bus.sent_with(0x211).size(), 0u);
}

TEST(HeadStart, SurvivesTwoLostAnswers) {
  HeadBench bench;
  int lost = 0;
  bench.to_head = [&](hal::CanFrame& f) { return f.id != 0x591 || ++lost > 2; };
  EXPECT_TRUE(bench.start());
}

TEST(HeadStart, FaultsOnARefusedObjectAndSaysWhich) {
  HeadBench bench;
  bench.tilt.refuses = {0x6085, 0};
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(3)));
  EXPECT_EQ(bench.head.tilt().failure, DriveFailure::kSetupRefused);
  EXPECT_EQ(bench.head.tilt().object.index, 0x6085);
  EXPECT_EQ(bench.head.tilt().abort_code, 0x08000022u);
}

TEST(HeadStart, FaultsOnAnObjectThatReadsBackDifferently) {
  HeadBench bench;
  bench.pan.forgets = {0x607D, 2};
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(3)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kSetupReadsDifferent);
  EXPECT_EQ(bench.head.pan().object.subindex, 2);
}

TEST(HeadStart, ResetsAFaultLeftOverFromBefore) {
  HeadBench bench;
  bench.pan.state = State::kFault;
  EXPECT_TRUE(bench.start());
}

TEST(HeadStart, GivesUpOnAFaultThatStays) {
  HeadBench bench;
  bench.pan.state = State::kFault;
  bench.pan.fault_is_permanent = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(5)));
  EXPECT_EQ(bench.head.pan().failure, DriveFailure::kDriveFault);
  EXPECT_EQ(std::ranges::count(bench.pan.controlwords, 0x80), 3);
}

TEST(HeadStart, FaultsOnADriveThatDoesNotFollow) {
  HeadBench bench;
  bench.tilt.stuck_switched_on = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(5)));
  EXPECT_EQ(bench.head.tilt().failure, DriveFailure::kStateTimedOut);
}

TEST(HeadStart, SwitchesNothingOnWhileThePositionIsUnknown) {
  HeadBench bench;
  bench.pan.mute_position = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(5)));
  EXPECT_TRUE(bench.pan.states.empty());
}

TEST(HeadStart, StartsAgainWhenADriveIsPoweredLate) {
  HeadBench bench;
  bench.pan.mute_sdo = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(3)));
  bench.pan.mute_sdo = false;
  bench.pan.boot(bench.now);
  EXPECT_TRUE(bench.start());
}

TEST(HeadStart, RepeatsTheOrderToStartUntilTheHeartbeatShowsIt) {
  HeadBench bench;
  int orders = 0;
  bench.to_drives = [&](hal::CanFrame& f) {
    return !(f.id == 0 && f.data[0] == 1 && f.data[1] == 0x11 && ++orders < 3);
  };
  EXPECT_TRUE(bench.start());
  EXPECT_EQ(orders, 3);
}

// --- running ---

TEST_F(RunningHead, SendsSyncAndHeartbeatInTheirTime) {
  bench.bus.sent.clear();
  bench.run(seconds(2));
  EXPECT_EQ(bench.bus.sent_with(0x080).size(), 100u);
  EXPECT_EQ(bench.bus.sent_with(0x701).size(), 20u);
}

TEST_F(RunningHead, RepeatsItsOrderEvery100Ms) {
  bench.bus.sent.clear();
  bench.run(seconds(2));
  for (const std::uint32_t id : {0x211u, 0x212u}) {
    EXPECT_EQ(bench.bus.sent_with(id).size(), 20u);
    for (const auto& frame : bench.bus.sent_with(id)) EXPECT_EQ(frame.data[0], 0x0F);
  }
}

TEST_F(RunningHead, TurnsWhereItIsTold) {
  bench.head.command({0.5, -0.2});
  EXPECT_TRUE(bench.head.state().moving);
  ASSERT_TRUE(bench.run_until([&] { return !bench.head.state().moving; }, seconds(3)));
  EXPECT_NEAR(bench.head.state().position.pan, 0.5, 2e-5);
  EXPECT_NEAR(bench.head.state().position.tilt, -0.2, 2e-5);
  EXPECT_NEAR(bench.head.state().target.pan, 0.5, 2e-5);
}

TEST_F(RunningHead, OffersASetPointWithBits4And5AndWithdrawsItWhenAcknowledged) {
  bench.pan.controlwords.clear();
  bench.head.command({0.5, 0});
  bench.run(seconds(0.2));
  EXPECT_THAT(bench.pan.controlwords, ElementsAre(0x3F, 0x0F));
}

TEST_F(RunningHead, TakesANewSetPointWhileStillMoving) {
  bench.head.command({0.7, 0});
  bench.run(seconds(0.2));
  bench.head.command({-0.7, 0});
  bench.run(seconds(0.2));
  EXPECT_EQ(bench.pan.set_points.back(), -40107);
}

TEST_F(RunningHead, EndsAtTheLastOfManyCommands) {
  for (int i = 0; i <= 100; ++i) {
    bench.head.command({0.005 * i, 0});
    bench.cycle();
  }
  bench.run(seconds(2));
  EXPECT_NEAR(bench.head.state().position.pan, 0.5, 2e-5);
}

TEST_F(RunningHead, IgnoresWhatIsNoNumber) {
  const auto before = bench.pan.set_points.size();
  bench.head.command({std::numeric_limits<double>::quiet_NaN(), 0.1});
  bench.head.command({0.1, std::numeric_limits<double>::infinity()});
  bench.run(seconds(0.5));
  EXPECT_EQ(bench.pan.set_points.size(), before);
}

TEST_F(RunningHead, StampsThePairOfPositionsWithTheirSync) {
  bench.run(seconds(1));
  const Time stamp = bench.head.state().stamp;
  EXPECT_GT(stamp, bench.now - milliseconds(30));
  EXPECT_LE(stamp, bench.now);
  bench.tilt.mute_position = true;
  bench.run(milliseconds(40));
  const Time last_pair = bench.head.state().stamp;
  bench.run(milliseconds(60));
  EXPECT_EQ(bench.head.state().stamp, last_pair);
}

TEST_F(RunningHead, DegradesWhen100MsPassWithoutStatusAndIsReadyAgainWithIt) {
  bench.pan.mute_status = true;
  bench.run(milliseconds(95));
  EXPECT_EQ(bench.head.state().health, HeadHealth::kReady);
  bench.run(milliseconds(35));
  EXPECT_EQ(bench.head.state().health, HeadHealth::kDegraded);
  bench.pan.mute_status = false;
  bench.run(milliseconds(50));
  EXPECT_EQ(bench.head.state().health, HeadHealth::kReady);
}

TEST_F(RunningHead, DegradesWithoutPositionsAndIgnoresCommandsMeanwhile) {
  bench.tilt.mute_position = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kDegraded, milliseconds(150)));
  bench.head.command({0.5, 0.5});
  bench.run(milliseconds(200));
  EXPECT_EQ(bench.tilt.set_points.back(), 0);
}

TEST_F(RunningHead, FaultsWhenAHeartbeatStaysAway300Ms) {
  bench.pan.mute_heartbeat = true;
  bench.run(milliseconds(195));  // the last one was heard up to 100 ms ago
  EXPECT_EQ(bench.head.state().health, HeadHealth::kReady);
  bench.run(milliseconds(115));
  fault_and_check(DriveFailure::kGone);
}

TEST_F(RunningHead, HoldsTheOtherDriveInAFault) {
  bench.head.command({0.7, 0.7});
  bench.run(milliseconds(200));
  bench.pan.mute_heartbeat = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(1)));
  bench.run(milliseconds(20));
  EXPECT_TRUE(bench.tilt.halted);
  const auto held_at = bench.tilt.position;
  bench.run(seconds(1));
  EXPECT_EQ(bench.tilt.position, held_at);
  bench.pan.mute_heartbeat = false;
  ASSERT_TRUE(bench.start());
  bench.run(seconds(1));
  EXPECT_EQ(bench.tilt.position, held_at);  // and stays there, instead of finishing the old move
  EXPECT_FALSE(bench.tilt.halted);
}

TEST_F(RunningHead, SetsADriveUpAgainThatBootsInMidRunWithoutAJump) {
  bench.head.command({0.3, 0});
  bench.run(seconds(1));
  bench.pan.written.clear();
  bench.pan.set_points.clear();
  bench.pan.position = 4321;  // pushed by hand while it had no torque
  bench.pan.boot(bench.now);
  bench.cycle();
  EXPECT_EQ(bench.head.state().health, HeadHealth::kStarting);
  ASSERT_TRUE(bench.start());
  bench.run(seconds(1));
  EXPECT_EQ(bench.pan.written.size(), setup_table(0x11, {}).size());
  EXPECT_THAT(bench.pan.set_points, ElementsAre(4321));
  EXPECT_EQ(bench.pan.position, 4321);
  EXPECT_EQ(bench.head.pan().boot_ups, 1u);
}

TEST_F(RunningHead, SetsADriveUpAgainThatComesBackAfterItWasGone) {
  bench.pan.mute_heartbeat = true;
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(1)));
  bench.pan.mute_heartbeat = false;
  EXPECT_TRUE(bench.start());
}

TEST_F(RunningHead, FaultsOnAnEmergencyAndStaysSoUntilRecovered) {
  bench.pan.emergency(0x8611, bench.now);
  bench.cycle();
  fault_and_check(DriveFailure::kEmergency);
  EXPECT_EQ(bench.head.pan().emergency_code, 0x8611);
  bench.run(seconds(2));
  fault_and_check(DriveFailure::kEmergency);
  EXPECT_TRUE(bench.pan.halted);
  bench.head.recover();
  EXPECT_TRUE(bench.start());
}

TEST_F(RunningHead, DoesNotMindTheEmergencyThatSaysAllIsWell) {
  bench.pan.emergency(0, bench.now);
  bench.run(milliseconds(50));
  EXPECT_EQ(bench.head.state().health, HeadHealth::kReady);
}

TEST_F(RunningHead, FaultsWithItsDriveAndResetsItOnlyWhenRecovered) {
  bench.pan.fault();
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, milliseconds(50)));
  bench.run(seconds(2));
  fault_and_check(DriveFailure::kDriveFault);
  EXPECT_EQ(bench.pan.state, State::kFault);
  bench.head.recover();
  EXPECT_TRUE(bench.start());
}

TEST_F(RunningHead, FaultsWhenASetPointIsNeverAcknowledged) {
  bench.pan.never_acknowledges = true;
  bench.head.command({0.4, 0});
  ASSERT_TRUE(bench.run_until(HeadHealth::kFault, seconds(3)));
  fault_and_check(DriveFailure::kSetPointTimedOut);
  EXPECT_EQ(std::ranges::count(bench.pan.set_points, 22918), 3);
}

TEST_F(RunningHead, CatchesUpAfterTheBusWasFull) {
  bench.bus.full = true;
  bench.head.command({0.4, 0});
  bench.run(milliseconds(90));
  bench.bus.full = false;
  bench.run(seconds(1));
  EXPECT_EQ(bench.head.state().health, HeadHealth::kReady);
  EXPECT_NEAR(bench.head.state().position.pan, 0.4, 2e-5);
}

TEST_F(RunningHead, IgnoresFramesOfOtherLengthAndOtherNodes) {
  hal::CanFrame shortened = *hal::bus::DriveMotion{.position_deg = 30}.pack(0x291);
  shortened.dlc = 4;
  shortened.stamp = bench.now;
  bench.head.receive(shortened);
  bench.head.receive({.id = 0x293, .dlc = 8, .data = {1, 2, 3}, .stamp = bench.now});
  bench.head.tick(bench.now);
  EXPECT_EQ(bench.head.state().position.pan, 0);
}

// --- properties ---

RC_GTEST_PROP(HeadCommands, NeverLeaveTheLimitsOnTheWire, ()) {
  HeadBench bench;
  RC_ASSERT(bench.start());
  const int count = *rc::gen::inRange(1, 10);
  for (int i = 0; i < count; ++i) {
    bench.head.command({*rc::gen::inRange(-8000, 8000) * 1e-3, *rc::gen::inRange(-8000, 8000) * 1e-3});
    bench.run(milliseconds(5 * *rc::gen::inRange(1, 60)));
  }
  for (const auto& frame : bench.bus.sent_with(0x211)) {
    RC_ASSERT(std::abs(hal::bus::DriveCommand::unpack(frame)->target_deg) <= 45.0005);
  }
  for (const auto& frame : bench.bus.sent_with(0x212)) {
    const double target = hal::bus::DriveCommand::unpack(frame)->target_deg;
    RC_ASSERT(target >= -30.0005 && target <= 45.0005);
  }
}

RC_GTEST_PROP(HeadActivation, NeverJumpsWhateverHappensOnTheBus, ()) {
  HeadConfig config;
  config.may_come_inside = false;
  HeadBench bench(config);
  const bool is_inside = *rc::gen::arbitrary<bool>();
  bench.pan.position = is_inside ? *rc::gen::inRange(-44000, 44000)
                                 : *rc::gen::element(-1, 1) * *rc::gen::inRange(45501, 90000);
  bench.tilt.position = *rc::gen::inRange(-29000, 44000);
  const std::int32_t pan = bench.pan.position, tilt = bench.tilt.position;
  // Loses frames both ways, lets drives boot and quick-stop at any time; no command is ever given.
  const unsigned loss = *rc::gen::inRange(0u, 20u);
  testing::Noise noise(*rc::gen::inRange(1u, 1u << 30));
  bench.to_head = bench.to_drives = [&](hal::CanFrame&) { return noise.percent() >= loss; };
  for (int i = 0; i < 20; ++i) {
    bench.run(milliseconds(5 * (noise.percent() + 1)));
    if (noise.percent() < 20) bench.pan.boot(bench.now);
    if (noise.percent() < 10) bench.tilt.quick_stop();
    if (noise.percent() < 10) bench.tilt.fault();
    if (noise.percent() < 20) bench.head.recover();
  }
  RC_ASSERT(bench.pan.position == pan);
  RC_ASSERT(bench.tilt.position == tilt);
  bench.to_head = bench.to_drives = [](hal::CanFrame&) { return true; };
  bench.run(seconds(2));
  bench.head.recover();
  RC_ASSERT(bench.start() == is_inside);
  RC_ASSERT(bench.pan.position == pan);
}

// --- configuration ---

TEST(HeadConfig, RefusesWhatNoDriveCouldDo) {
  testing::ScriptedBus bus;
  const auto broken = [&](auto change) {
    HeadConfig config;
    change(config);
    EXPECT_THROW((Cia402Head{bus, config}), InputError);
  };
  broken([](HeadConfig& c) { c.pan_node = 0x13; });
  broken([](HeadConfig& c) { c.pan_node = c.tilt_node; });
  broken([](HeadConfig& c) { c.limits.lower.pan = c.limits.upper.pan; });
  broken([](HeadConfig& c) { c.limits.upper.tilt = std::numeric_limits<double>::quiet_NaN(); });
  broken([](HeadConfig& c) { c.limits.velocity = 0; });
  broken([](HeadConfig& c) { c.limits.acceleration = -1; });
  broken([](HeadConfig& c) { c.following_error = 0; });
  EXPECT_NO_THROW((Cia402Head{bus, HeadConfig{}}));
}

}  // namespace
}  // namespace headway::drivers
