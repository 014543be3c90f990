#include "sim_hal/head_drive.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/sim_hal/drive_bench.h"

namespace headway::sim {
namespace {

constexpr std::uint32_t kNoObject = 0x06020000, kNoSubIndex = 0x06090011, kReadOnly = 0x06010002,
                        kWrongLength = 0x06070010, kTooHigh = 0x06090031, kBadValue = 0x06090030,
                        kUnsupported = 0x06010000, kNotMappable = 0x06040041, kTooLong = 0x06040042,
                        kUnknownCommand = 0x05040001;

TEST(HeadDriveNetwork, AnnouncesItselfOnceAfterBooting) {
  DriveBench bench;
  bench.run(0.04);
  EXPECT_TRUE(bench.frames.empty());
  bench.run(0.5);
  const auto boots = bench.heard(0x711);
  ASSERT_EQ(boots.size(), 1U);
  EXPECT_EQ(boots[0].dlc, 1);
  EXPECT_EQ(boots[0].data[0], 0);
  EXPECT_EQ(bench.drive.nmt_state(), NmtState::kPreOperational);
}

TEST(HeadDriveNetwork, ObeysNetworkManagement) {
  DriveBench bench;
  bench.run(0.1);
  const auto after = [&](std::uint8_t command, std::uint8_t node) {
    bench.send(0x000, {command, node});
    bench.run(0.005);
    return bench.drive.nmt_state();
  };
  EXPECT_EQ(after(1, 0x12), NmtState::kPreOperational) << "meant for another node";
  EXPECT_EQ(after(1, 0x11), NmtState::kOperational);
  EXPECT_EQ(after(2, 0x11), NmtState::kStopped);
  EXPECT_EQ(bench.read(0x1000).abort, 0xffffffff) << "a stopped node does not answer";
  EXPECT_EQ(after(128, 0), NmtState::kPreOperational) << "all nodes";
  bench.frames.clear();
  EXPECT_EQ(after(129, 0x11), NmtState::kInitialising);
  bench.run(0.1);
  EXPECT_EQ(bench.heard(0x711).size(), 1U);
}

TEST(HeadDriveNetwork, SendsHeartbeatsAtTheAskedRate) {
  DriveBench bench;
  bench.run(0.1);
  EXPECT_EQ(bench.write(0x1017, 0, 2, 100), 0U);
  bench.frames.clear();
  bench.run(1.0);
  const auto beats = bench.heard(0x711);
  EXPECT_EQ(beats.size(), 10U);
  EXPECT_EQ(beats.at(0).data[0], 127);
}

TEST(HeadDriveSdo, ReadsAndWritesWithTheRightLengths) {
  DriveBench bench;
  bench.run(0.1);
  EXPECT_EQ(bench.read(0x1000).value, 0x00020192U);
  EXPECT_EQ(bench.read(0x6041).bytes, 2);
  EXPECT_EQ(bench.read(0x6061).bytes, 1);
  EXPECT_EQ(bench.write(0x607D, 1, 4, -45000), 0U);
  EXPECT_EQ(static_cast<std::int32_t>(bench.read(0x607D, 1).value), -45000);
  EXPECT_EQ(bench.write(0x1016, 1, 4, 0x0001012C), 0U);
  EXPECT_EQ(bench.read(0x1016, 1).value, 0x0001012CU);
  const auto unsized = bench.sdo({0x22, 0x17, 0x10, 0, 0x64, 0, 0, 0});
  EXPECT_EQ(unsized.command, 0x60);
  EXPECT_EQ(bench.read(0x1017).value, 100U);
}

TEST(HeadDriveSdo, AbortsWithTheStandardsCodes) {
  DriveBench bench;
  bench.run(0.1);
  EXPECT_EQ(bench.read(0x2345).abort, kNoObject);
  EXPECT_EQ(bench.read(0x607D, 3).abort, kNoSubIndex);
  EXPECT_EQ(bench.write(0x6041, 0, 2, 1), kReadOnly);
  EXPECT_EQ(bench.write(0x6040, 0, 4, 1), kWrongLength);
  EXPECT_EQ(bench.write(0x6060, 0, 1, 3), kBadValue) << "profile velocity is not there";
  EXPECT_EQ(bench.write(0x1014, 0, 4, 0x91), kReadOnly);
  EXPECT_EQ(bench.write(0x1016, 1, 4, 0x00800000), kTooHigh);
  EXPECT_EQ(bench.write(0x605A, 0, 2, 4), kBadValue);
  EXPECT_EQ(bench.write(0x60A8, 0, 4, 0x00B40000), kBadValue) << "radians";
  EXPECT_EQ(bench.write(0x1800, 2, 1, 250), kBadValue) << "a reserved transmission type";
  EXPECT_EQ(bench.sdo({0xE0, 0, 0, 0, 0, 0, 0, 0}).abort, kUnknownCommand);
  EXPECT_EQ(bench.sdo({0x21, 0x17, 0x10, 0, 9, 0, 0, 0}).abort, kUnsupported) << "segmented transfer";
}

TEST(HeadDriveSdo, GuardsTheMappingAsTheStandardAsks) {
  DriveBench bench;
  bench.run(0.1);
  EXPECT_EQ(bench.write(0x1A00, 0, 1, 0), kUnsupported) << "the PDO is still on";
  EXPECT_EQ(bench.write(0x1800, 1, 4, 0x192), kBadValue) << "its identifier cannot change while it is on";
  EXPECT_EQ(bench.write(0x1800, 1, 4, 0x80000191), 0U);
  EXPECT_EQ(bench.write(0x1A00, 1, 4, 0x60640020), kUnsupported) << "the mapping is not emptied";
  EXPECT_EQ(bench.write(0x1A00, 0, 1, 0), 0U);
  EXPECT_EQ(bench.write(0x1A00, 1, 4, 0x10000020), kNotMappable);
  EXPECT_EQ(bench.write(0x1A00, 1, 4, 0x60640010), kNotMappable) << "half an object";
  for (std::uint8_t sub = 1; sub <= 3; ++sub) EXPECT_EQ(bench.write(0x1A00, sub, 4, 0x60640020), 0U);
  EXPECT_EQ(bench.write(0x1A00, 0, 1, 3), kTooLong);
  EXPECT_EQ(bench.write(0x1A00, 0, 1, 2), 0U);
  EXPECT_EQ(bench.write(0x1400, 1, 4, 0x80000211), 0U);
  EXPECT_EQ(bench.write(0x1600, 0, 1, 0), 0U);
  EXPECT_EQ(bench.write(0x1600, 1, 4, 0x60410010), kNotMappable) << "nobody can write a statusword";
}

RC_GTEST_PROP(HeadDriveSdo, AnswersEveryRequestOnceWhateverItSays, ()) {
  DriveBench bench;
  bench.run(0.1);
  std::vector<std::uint8_t> request(8);
  for (auto& b : request) b = static_cast<std::uint8_t>(*rc::gen::inRange(0, 256));
  bench.sdo(request);
  RC_ASSERT(bench.heard(0x591).size() == (request[0] >> 5 == 4 ? 0U : 1U));
}

TEST(HeadDrivePdo, AnswersEachSyncWithStatusAndPosition) {
  DriveBench bench;
  bench.set_up();
  bench.frames.clear();
  for (int i = 0; i < 5; ++i) {
    bench.send(0x080, {});
    bench.run(0.02);
  }
  ASSERT_EQ(bench.heard(0x191).size(), 5U);
  ASSERT_EQ(bench.heard(0x291).size(), 5U);
  EXPECT_EQ(bench.heard(0x191)[0].dlc, 3);
  EXPECT_EQ(bench.heard(0x191)[0].data[0] & 0x4F, 0x40) << "switch on disabled";
  EXPECT_EQ(bench.heard(0x291)[0].dlc, 8);
}

TEST(HeadDrivePdo, StaysSilentBeforeItIsStarted) {
  DriveBench bench;
  bench.run(0.1);
  bench.send(0x080, {});
  bench.run(0.05);
  EXPECT_TRUE(bench.heard(0x191).empty());
}

/// (command, state before) -> state after, read off the state diagram of CiA 402.
TEST(HeadDrivePower, WalksTheStateDiagram) {
  using enum PowerState;
  struct Arrow {
    PowerState from;
    std::uint16_t word;
    PowerState to;
  };
  const std::vector<Arrow> arrows{
      {kSwitchOnDisabled, 0x06, kReadyToSwitchOn},  {kSwitchOnDisabled, 0x07, kSwitchOnDisabled},
      {kSwitchOnDisabled, 0x0F, kSwitchOnDisabled}, {kReadyToSwitchOn, 0x07, kSwitchedOn},
      {kReadyToSwitchOn, 0x00, kSwitchOnDisabled},  {kReadyToSwitchOn, 0x02, kSwitchOnDisabled},
      {kSwitchedOn, 0x0F, kOperationEnabled},       {kSwitchedOn, 0x06, kReadyToSwitchOn},
      {kSwitchedOn, 0x00, kSwitchOnDisabled},       {kSwitchedOn, 0x02, kSwitchOnDisabled},
      {kOperationEnabled, 0x07, kSwitchedOn},       {kOperationEnabled, 0x06, kReadyToSwitchOn},
      {kOperationEnabled, 0x00, kSwitchOnDisabled}, {kOperationEnabled, 0x02, kQuickStopActive},
      {kOperationEnabled, 0x0F, kOperationEnabled}, {kQuickStopActive, 0x0F, kOperationEnabled},
      {kQuickStopActive, 0x00, kSwitchOnDisabled},  {kQuickStopActive, 0x06, kQuickStopActive},
  };
  for (const Arrow& arrow : arrows) {
    DriveBench bench;
    bench.set_up();
    const std::vector<std::uint16_t> way{0x06, 0x07, 0x0F, 0x02};
    const auto steps = arrow.from == kSwitchOnDisabled   ? 0
                       : arrow.from == kReadyToSwitchOn  ? 1
                       : arrow.from == kSwitchedOn       ? 2
                       : arrow.from == kOperationEnabled ? 3
                                                         : 4;
    for (int i = 0; i < steps; ++i) bench.order(way[static_cast<std::size_t>(i)], 0);
    ASSERT_EQ(bench.drive.power_state(), arrow.from);
    bench.order(arrow.word, 0);
    EXPECT_EQ(bench.drive.power_state(), arrow.to)
        << "from " << static_cast<int>(arrow.from) << " by " << arrow.word;
  }
}

TEST(HeadDriveMotion, GoesWhereItIsToldInTheTimeOfItsProfile) {
  DriveBench bench;
  bench.set_up();
  bench.enable();
  bench.order(0x0F, 30000);
  EXPECT_NEAR(bench.angle(), 0, 1) << "a target alone moves nothing";
  bench.order(0x3F, 30000);
  EXPECT_NE(bench.drive.status_word() & 1 << 12, 0) << "acknowledged";
  EXPECT_EQ(bench.drive.status_word() & 1 << 10, 0) << "not there yet";
  bench.order(0x2F, 30000);
  EXPECT_EQ(bench.drive.status_word() & 1 << 12, 0) << "handshake over";
  const double expected = 30.0 / 57 + 57.0 / 230;
  bench.run(expected - 0.06);
  EXPECT_LT(bench.angle(), 29900);
  bench.run(0.12);
  EXPECT_NEAR(bench.angle(), 30000, 20);
  EXPECT_NE(bench.drive.status_word() & 1 << 10, 0) << "target reached";
}

TEST(HeadDriveHoming, FindsItsSwitchWhenAskedAndReadsZeroThere) {
  DriveBench bench({.start_angle = 0.3, .homed = false});
  bench.set_up();
  EXPECT_EQ(bench.write(0x6098, 0, 1, 33), kBadValue);
  EXPECT_EQ(bench.write(0x6098, 0, 1, 17), 0U);
  EXPECT_EQ(bench.read(0x6064).value, 0U) << "it takes where it was switched on for zero";
  bench.mode = 6;
  bench.enable();
  bench.run(0.5);
  EXPECT_EQ(bench.drive.status_word() & 1 << 12, 0) << "does not know where it is";
  EXPECT_NEAR(bench.drive.angle(), 0.3, 1e-9) << "and does not move until it is asked";
  bench.order(0x1F, 0);
  bench.run(1);
  EXPECT_EQ(bench.drive.status_word() & 1 << 12, 0) << "on its way";
  bench.run(4);
  EXPECT_NE(bench.drive.status_word() & 1 << 12, 0);
  EXPECT_NE(bench.drive.status_word() & 1 << 10, 0);
  EXPECT_NEAR(bench.drive.angle(), 0, 1e-4);
  EXPECT_EQ(bench.read(0x6064).value, 0U);
  bench.mode = 1;
  bench.go_to(10000);
  bench.run(2);
  EXPECT_NEAR(bench.angle(), 10000, 60);
}

TEST(HeadDriveHoming, StopsWhenBit4IsTakenBackAndDoesNotKnow) {
  DriveBench bench({.start_angle = 0.3, .homed = false});
  bench.set_up();
  bench.write(0x6098, 0, 1, 17);
  bench.mode = 6;
  bench.enable();
  bench.order(0x1F, 0);
  bench.run(1);
  bench.order(0x0F, 0);
  bench.run(1);
  const double stands = bench.drive.angle();
  EXPECT_GT(stands, 0.1);
  bench.run(3);
  EXPECT_EQ(bench.drive.angle(), stands);
  EXPECT_EQ(bench.drive.status_word() & 1 << 12, 0);
}

TEST(HeadDriveCyclic, IsWhereItIsToldWhenTheNextTargetComesAndStaysWithoutOne) {
  DriveBench bench({.lag = 0});
  bench.set_up();
  bench.map(0x1400, 0x1600, 0x211, 1, {0x60400010, 0x60600008, 0x607A0020});
  bench.write(0x60C2, 1, 1, 20);
  bench.mode = 8;
  const auto cycle = [&](std::uint16_t word, std::int32_t target) {
    bench.order(word, target);
    bench.send(0x080, {});
    bench.run(0.015);
  };
  for (const int word : {0x06, 0x07, 0x0F, 0x0F}) cycle(static_cast<std::uint16_t>(word), 0);
  ASSERT_NE(bench.drive.status_word() & 1 << 12, 0) << "follows";
  for (int i = 1; i <= 10; ++i) {
    bench.order(0x0F, 800 * i);
    EXPECT_NEAR(bench.angle(), 800 * (i - 1), 1) << "counts from the SYNC on";
    bench.send(0x080, {});
    bench.run(0.010);
    EXPECT_NEAR(bench.angle(), 800 * (i - 1) + 400, 90);
    bench.run(0.010);
  }
  bench.run(0.5);
  EXPECT_NEAR(bench.angle(), 8000, 1);
  cycle(0x0F, 46000);
  bench.run(0.1);
  EXPECT_NEAR(bench.angle(), 45000, 1) << "its own limits hold";
  EXPECT_NE(bench.drive.status_word() & 1 << 11, 0);
}

TEST(HeadDriveMotion, ReportsThePositionOfTheMomentOfTheSync) {
  DriveBench bench;
  bench.set_up();
  bench.enable();
  bench.go_to(40000);
  bench.run(0.3);
  bench.frames.clear();
  const double before = bench.angle(), speed = bench.drive.velocity() * 180e3 / 3.14159265358979;
  bench.send(0x080, {});
  bench.run(0.005);
  const auto d = bench.heard(0x291).at(0).data;
  const auto position =
      static_cast<std::int32_t>(d[0] | d[1] << 8 | d[2] << 16 | static_cast<std::uint32_t>(d[3]) << 24);
  const double sync_at = to_seconds(frame_time(0, 500e3));
  EXPECT_NEAR(position, before + speed * sync_at, 3);
  EXPECT_NEAR(bench.angle(), before + speed * 0.005, 3);
}

TEST(HeadDriveMotion, TakesANewTargetAtOnceOrAfterTheLast) {
  DriveBench bench;
  bench.set_up();
  bench.enable();
  bench.go_to(40000);
  bench.run(0.3);
  bench.order(0x2F, -10000);
  bench.order(0x3F, -10000);
  bench.order(0x2F, -10000);
  bench.run(0.3);
  EXPECT_LT(bench.angle(), 20000) << "turned back on the way";
  bench.run(1.0);
  EXPECT_NEAR(bench.angle(), -10000, 20);

  bench.order(0x1F, 5000);  // without bit 5: one after the other
  bench.order(0x0F, 5000);
  bench.order(0x1F, -20000);
  EXPECT_NE(bench.drive.status_word() & 1 << 12, 0);
  bench.order(0x0F, -20000);
  EXPECT_NE(bench.drive.status_word() & 1 << 12, 0) << "the buffer is full";
  bool was_there = false;
  for (int i = 0; i < 300; ++i) {
    bench.run(0.005);
    was_there = was_there || std::abs(bench.angle() - 5000) < 60;
  }
  EXPECT_TRUE(was_there);
  EXPECT_NEAR(bench.angle(), -20000, 20);
}

TEST(HeadDriveMotion, ClampsToTheSoftLimits) {
  DriveBench bench;
  bench.set_up();
  bench.enable();
  bench.go_to(90000);
  bench.run(2);
  EXPECT_NEAR(bench.angle(), 45000, 20);
  EXPECT_NE(bench.drive.status_word() & 1 << 11, 0) << "internal limit active";
  bench.go_to(0);
  EXPECT_EQ(bench.drive.status_word() & 1 << 11, 0);
}

TEST(HeadDriveMotion, HaltsAndGoesOn) {
  DriveBench bench;
  bench.set_up();
  bench.enable();
  bench.go_to(40000);
  bench.run(0.2);
  bench.order(0x12F, 40000);
  bench.run(0.5);
  const double halted = bench.angle();
  EXPECT_LT(halted, 30000);
  bench.run(0.5);
  EXPECT_EQ(bench.angle(), halted);
  bench.order(0x2F, 40000);
  bench.run(1.5);
  EXPECT_NEAR(bench.angle(), 40000, 20);
}

TEST(HeadDriveWatchdog, StopsQuicklyAndHoldsWhenTheMasterIsLost) {
  DriveBench bench;
  bench.set_up();
  bench.enable();
  bench.go_to(45000);
  bench.beating = false;
  bench.send(0x701, {5});
  bench.frames.clear();
  bench.run(0.295);
  EXPECT_EQ(bench.drive.power_state(), PowerState::kOperationEnabled);
  bench.run(0.4);
  EXPECT_EQ(bench.drive.power_state(), PowerState::kQuickStopActive);
  const double held = bench.angle();
  EXPECT_LT(held, 40000);
  bench.run(1);
  EXPECT_EQ(bench.angle(), held);
  const auto emergencies = bench.heard(0x091);
  ASSERT_EQ(emergencies.size(), 1U);
  EXPECT_EQ(emergencies[0].data[0] | emergencies[0].data[1] << 8, 0x8130);
  EXPECT_EQ(emergencies[0].data[2], 0x11);

  bench.beating = true;
  bench.run(0.2);
  EXPECT_EQ(bench.heard(0x091).size(), 2U) << "and says when it is over";
  bench.order(0x0F, 0);
  EXPECT_EQ(bench.drive.power_state(), PowerState::kOperationEnabled);
  EXPECT_NEAR(bench.angle(), held, 1) << "without a jump";
}

TEST(HeadDriveFaults, ReportsAStalledJointAndRecovers) {
  DriveBench bench;
  bench.set_up();
  bench.enable();
  bench.drive.set_stalled(true);
  bench.frames.clear();
  bench.go_to(20000);
  bench.run(0.6);
  EXPECT_EQ(bench.drive.power_state(), PowerState::kFault);
  EXPECT_NEAR(bench.angle(), 0, 1e-6);
  ASSERT_EQ(bench.heard(0x091).size(), 1U);
  EXPECT_EQ(bench.heard(0x091)[0].data[0] | bench.heard(0x091)[0].data[1] << 8, 0x8611);
  EXPECT_EQ(bench.read(0x603F).value, 0x8611U);

  bench.order(0x0F, 0);
  EXPECT_EQ(bench.drive.power_state(), PowerState::kFault) << "only a reset leads out";
  bench.drive.set_stalled(false);
  bench.order(0x80, 0);
  EXPECT_EQ(bench.drive.power_state(), PowerState::kSwitchOnDisabled);
  bench.enable();
  bench.go_to(20000);
  bench.run(1);
  EXPECT_NEAR(bench.angle(), 20000, 20);
}

TEST(HeadDriveFaults, ForgetsItsSetUpWhenItReboots) {
  DriveBench bench;
  bench.set_up();
  bench.enable();
  bench.go_to(20000);
  bench.run(0.2);
  const double held = bench.angle();
  bench.frames.clear();
  bench.drive.reboot();
  bench.run(0.3);
  EXPECT_EQ(bench.heard(0x711).back().data[0], 0) << "boot-up, and no heartbeat after it";
  EXPECT_EQ(bench.drive.nmt_state(), NmtState::kPreOperational);
  EXPECT_EQ(bench.drive.power_state(), PowerState::kSwitchOnDisabled);
  EXPECT_NEAR(bench.angle(), held, 1) << "the brake holds";
  EXPECT_EQ(bench.read(0x1016, 1).value, 0U);
  EXPECT_EQ(bench.read(0x1A00, 0).value, 1U);
}

TEST(HeadDrive, RefusesAConfigurationThatCannotBe) {
  EXPECT_THROW(HeadDriveConfig{.node = 0}.validate(), InputError);
  EXPECT_THROW(HeadDriveConfig{.node = 128}.validate(), InputError);
  EXPECT_THROW(HeadDriveConfig{.lag = -1}.validate(), InputError);
}

}  // namespace
}  // namespace headway::sim
