#include "sim_hal/robot.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/sim_hal/walk_bench.h"

namespace headway::sim {
namespace {

using Request = bus::WalkControl::Request;

/// A robot, and a master that walks it.
class RobotBench {
 public:
  explicit RobotBench(const RobotConfig& config = {}, const Pose2& start = {})
      : robot(config, start), master(robot.bus()) {}

  void tick() {
    now += SimRobot::kPeriod;
    robot.step(now);
    master.listen();
    if (session != 0 && now.time_since_epoch() % seconds(0.04) == Duration{}) {
      master.send_control(session, Request::kWalk);
    }
    // As soon as the session is open: all steps as there is room for them, the newest repeated until
    // accepted.
    if (session == 0 || master.status.session != session ||
        now.time_since_epoch() % seconds(0.04) != seconds(0.02))
      return;
    const std::size_t accepted = master.status.seq_accepted == 255 ? 0 : master.status.seq_accepted + 1U;
    for (std::size_t i = accepted; i < std::min(steps.size(), accepted + 3); ++i)
      master.send_step(session, static_cast<std::uint32_t>(i), steps[i]);
  }
  void run(double duration) {
    for (const Time end = now + seconds(duration); now < end;) tick();
  }
  void sdo(int node, std::uint16_t index, int bytes, std::int64_t value) {
    hal::CanFrame f{.id = static_cast<std::uint32_t>(0x600 + node), .dlc = 8};
    f.data = {static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2), static_cast<std::uint8_t>(index),
              static_cast<std::uint8_t>(index >> 8)};
    for (int i = 0; i < 4; ++i)
      f.data[static_cast<std::size_t>(4 + i)] = static_cast<std::uint8_t>(value >> (8 * i));
    robot.bus().send(f);
    run(0.005);
  }
  /// By SDO alone, which a drive takes before it is started.
  void turn_head(int node, std::int32_t target) {
    sdo(node, 0x6060, 1, 1);
    sdo(node, 0x607A, 4, target);
    for (const int word : {0x06, 0x07, 0x0F, 0x3F, 0x2F}) sdo(node, 0x6040, 2, word);
  }

  SimRobot robot;
  WalkMaster master;
  Time now{};
  std::uint8_t session = 0;
  std::vector<hal::Footstep> steps;
};

TEST(SimRobot, StandsWhereTheWorldPutsIt) {
  RobotBench bench({}, {2, -3, 0.8});
  bench.run(0.5);
  EXPECT_NEAR(bench.robot.map_from_chest().translation().x(), 2, 1e-9);
  EXPECT_NEAR(bench.robot.map_from_chest().translation().y(), -3, 1e-9);
  EXPECT_NEAR(bench.robot.map_from_base().yaw, 0.8, 1e-9);
  EXPECT_NEAR(bench.master.chest_xy.back().x, 2, 1e-3);
  EXPECT_FALSE(bench.robot.fallen());
  EXPECT_EQ(bench.robot.path_walked(), 0);
}

TEST(SimRobot, WalksWhereTheStepsLead) {
  RobotBench bench;
  bench.session = 1;
  bench.steps = forward_steps(12);
  bench.run(16);
  EXPECT_EQ(bench.master.status.seq_accepted, 11);
  EXPECT_EQ(bench.master.status.state, bus::WalkStatus::State::kStanding);
  EXPECT_NEAR(bench.robot.map_from_base().x, 2.2, 0.03);
  EXPECT_NEAR(bench.robot.path_walked(), 2.2, 0.05);
  EXPECT_FALSE(bench.robot.fallen());
}

TEST(SimRobot, ReportsItsChestNearTheTruthWhileItSways) {
  RobotBench bench;
  bench.session = 1;
  bench.steps = forward_steps(8);
  double largest = 0, sway = 0;
  for (int i = 0; i < 2000; ++i) {
    bench.tick();
    const Eigen::Vector3d truth = bench.robot.map_from_chest().translation();
    const Eigen::Vector3d believed = bench.robot.control().odom_from_chest().translation();
    largest = std::max(largest, (truth - believed).norm());
    sway = std::max(sway, std::abs(truth.y()));
  }
  EXPECT_LT(largest, 0.03);
  EXPECT_GT(largest, 0.001) << "the truth is not what is reported";
  EXPECT_GT(sway, 0.02);
}

TEST(SimRobot, TakesPicturesAtExactTimesFromThePoseOfThatMoment) {
  RobotConfig config;
  config.frame_rate = 30;
  config.kinematics.tilt_from_camera.linear() = hal::body_from_optical(0.1);
  RobotBench bench(config);
  std::vector<std::pair<Time, Eigen::Isometry3d>> pictures;
  bench.robot.on_exposure([&](Time t, const Eigen::Isometry3d& pose) { pictures.emplace_back(t, pose); });
  bench.session = 1;
  bench.steps = forward_steps(6);
  std::vector<std::pair<Time, Eigen::Isometry3d>> truth;
  for (int i = 0; i < 1000; ++i) {
    bench.tick();
    truth.emplace_back(bench.now, bench.robot.map_from_camera());
  }
  ASSERT_EQ(pictures.size(), 151U);
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const auto& [at, pose] = pictures[k];
    EXPECT_EQ(at, Time(seconds(static_cast<double>(k) / 30)));
    const auto later = std::find_if(truth.begin(), truth.end(), [&](const auto& s) { return s.first >= at; });
    if (later == truth.begin() || later == truth.end()) continue;
    const auto earlier = later - 1;
    const double share = to_seconds(at - earlier->first) / 0.005;
    const Eigen::Vector3d expected =
        (1 - share) * earlier->second.translation() + share * later->second.translation();
    EXPECT_LT((pose.translation() - expected).norm(), 1e-6);
  }
}

TEST(SimRobot, TurnsItsHead) {
  RobotBench bench;
  bench.run(0.1);
  bench.turn_head(0x11, 20000);
  bench.turn_head(0x12, -10000);
  bench.run(4);
  EXPECT_NEAR(bench.robot.head().pan, 20 * M_PI / 180, 1e-3);
  EXPECT_NEAR(bench.robot.head().tilt, -10 * M_PI / 180, 1e-3);
}

TEST(SimRobot, FallsFromGiantStepsAndSaysSo) {
  RobotConfig config;
  config.control.limits.forward = 0.46;
  RobotBench bench(config);
  bench.session = 1;
  bench.steps = forward_steps(8, 0.45);
  bench.run(8);
  EXPECT_TRUE(bench.robot.fallen());
  EXPECT_EQ(bench.master.status.state, bus::WalkStatus::State::kFault);
  const Eigen::Isometry3d fell_at = bench.robot.map_from_chest();
  bench.run(1);
  EXPECT_TRUE(bench.robot.map_from_chest().isApprox(fell_at));
}

/// A wall across the way: everything beyond x = 1 m, above the floor.
std::optional<std::string> wall(const BodyBox& box) {
  double front = -1e9;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5}) {
      const Eigen::Vector3d corner(x * box.size.x(), y * box.size.y(), 0);
      front = std::max(front, (box.map_from_box * corner).x());
    }
  return front > 1 ? std::optional<std::string>("wall") : std::nullopt;
}

TEST(SimRobot, NoticesTheFirstContactWithTheWorld) {
  RobotBench bench;
  bench.robot.on_touch([](const BodyBox& box, Time) { return wall(box); });
  bench.run(1);
  EXPECT_FALSE(bench.robot.collision());
  bench.session = 1;
  bench.steps = forward_steps(10);
  double base_x = 0;
  while (!bench.robot.collision() && bench.now < at_seconds(15)) {
    bench.tick();
    base_x = bench.robot.map_from_base().x;
  }
  ASSERT_TRUE(bench.robot.collision());
  EXPECT_EQ(bench.robot.collision()->object, "wall");
  EXPECT_EQ(bench.robot.collision()->time, bench.now);
  EXPECT_NEAR(base_x, 1 - 0.2, 0.1);
  const Time first = bench.robot.collision()->time;
  bench.run(0.5);
  EXPECT_EQ(bench.robot.collision()->time, first);
}

TEST(SimRobot, IsShapedAsConfigured) {
  RobotBench bench({}, {1, 1, 0});
  const auto shape = bench.robot.shape();
  ASSERT_EQ(shape.size(), 5U);
  EXPECT_EQ(shape[0].part, "torso");
  EXPECT_NEAR(shape[0].size.y(), 0.60, 1e-12);
  EXPECT_NEAR(shape[0].map_from_box.translation().z(), (0.75 + 1.5) / 2, 1e-12);
  EXPECT_NEAR(shape[3].map_from_box.translation().y(), 1.095, 1e-12) << "left foot";
}

TEST(SimRobot, SuffersTheFaultsOfItsPlan) {
  RobotConfig config;
  config.faults = {
      {.kind = FaultKind::kCanLoss, .begin = seconds(0.5), .length = seconds(0.2), .id = 0x130},
      {.kind = FaultKind::kCanCorruption, .begin = seconds(0.8), .length = seconds(0.1), .id = 0x131},
      {.kind = FaultKind::kCanDelay,
       .begin = seconds(1.0),
       .length = seconds(0.1),
       .id = 0x132,
       .delay = seconds(0.05)},
      {.kind = FaultKind::kBusOff, .begin = seconds(1.5), .length = seconds(0.2)},
      {.kind = FaultKind::kRebootPan, .begin = seconds(2.0), .length = seconds(0.1)},
      {.kind = FaultKind::kSilentControl, .begin = seconds(2.5), .length = seconds(0.2)}};
  RobotBench bench(config);
  bench.run(0.5);
  const int before = bench.master.statuses;
  bench.run(0.2);
  EXPECT_LE(bench.master.statuses, before + 1);
  bench.run(0.1);
  EXPECT_GT(bench.master.statuses, before + 1);
  bench.run(0.4);
  EXPECT_NEAR(static_cast<double>(bench.robot.can().counters().fault_corrupted), 5, 1);
  EXPECT_NEAR(static_cast<double>(bench.robot.can().counters().fault_delayed), 5, 1);
  bench.run(0.4);
  EXPECT_EQ(bench.robot.bus().state(), hal::CanBusState::kBusOff);
  bench.run(0.2);
  EXPECT_EQ(bench.robot.bus().state(), hal::CanBusState::kErrorActive);
  bench.run(0.23);
  EXPECT_EQ(bench.robot.pan_drive().nmt_state(), NmtState::kInitialising);
  bench.run(0.5);
  EXPECT_EQ(bench.robot.pan_drive().nmt_state(), NmtState::kPreOperational);
  const int heard = bench.master.statuses;
  bench.run(0.1);
  EXPECT_EQ(bench.master.statuses, heard);
}

TEST(SimRobot, LosesTheShareOfFramesThatItsPlanSays) {
  RobotConfig config;
  config.faults = {
      {.kind = FaultKind::kCanLoss, .begin = seconds(1), .length = seconds(20), .share = 0.3, .id = 0x130}};
  RobotBench bench(config);
  bench.run(1);
  const int before = bench.master.statuses;
  bench.run(20);
  const int lost = 1000 - (bench.master.statuses - before);
  EXPECT_NEAR(lost, 300, 4 * std::sqrt(1000 * 0.3 * 0.7));  // 4 sigma of the binomial distribution
  EXPECT_EQ(bench.robot.can().counters().fault_dropped, static_cast<std::uint64_t>(lost));
}

TEST(SimRobot, BeginsTheFaultsThatWaitForTheFirstStepWithIt) {
  RobotConfig config;
  config.faults = {{.kind = FaultKind::kBusOff,
                    .after = FaultClock::kFirstStep,
                    .begin = seconds(1),
                    .length = seconds(0.5)}};
  RobotBench bench(config);
  bench.run(5);
  EXPECT_FALSE(bench.robot.faults().begin(0)) << "no step yet";
  bench.session = 1;
  bench.steps = forward_steps(12);
  while (bench.robot.control().pattern().started() == 0) bench.tick();
  const Time first = bench.now;
  bench.run(0.995);
  EXPECT_EQ(bench.robot.bus().state(), hal::CanBusState::kErrorActive);
  bench.run(0.03);
  EXPECT_EQ(bench.robot.bus().state(), hal::CanBusState::kBusOff);
  EXPECT_NEAR(to_seconds(*bench.robot.faults().begin(0) - first), 1, 0.0051);
  bench.run(0.5);
  EXPECT_EQ(bench.robot.bus().state(), hal::CanBusState::kErrorActive);
}

TEST(SimRobot, KeepsAFaultUpWhileAnotherOfItsKindIsOn) {
  RobotConfig config;
  config.faults = {{.kind = FaultKind::kBusOff, .begin = seconds(1), .length = seconds(1)},
                   {.kind = FaultKind::kBusOff, .begin = seconds(1.5), .length = seconds(1)}};
  RobotBench bench(config);
  bench.run(2.2);
  EXPECT_EQ(bench.robot.bus().state(), hal::CanBusState::kBusOff);
  bench.run(0.4);
  EXPECT_EQ(bench.robot.bus().state(), hal::CanBusState::kErrorActive);
}

TEST(SimRobot, HearsAndSpeaksLateWhenItsControlComputerIsSlow) {
  RobotConfig config;
  config.faults = {
      {.kind = FaultKind::kSlowControl, .begin = seconds(1), .length = seconds(2), .delay = seconds(0.06)}};
  RobotBench bench(config);
  bench.run(1.1);
  const std::uint64_t delayed = bench.robot.can().counters().fault_delayed;
  bench.run(1);
  // 50 each of status, both halves of the chest pose, and one time.
  EXPECT_NEAR(static_cast<double>(bench.robot.can().counters().fault_delayed - delayed), 151, 3);
  ASSERT_FALSE(bench.master.frames.empty());
}

/// How a walk of twelve steps ends when the control computer begins anew amid it.
TEST(SimRobot, FinishesTheStepsUnderWayWhenItsControlComputerBeginsAnew) {
  RobotConfig config;
  config.faults = {{.kind = FaultKind::kRestartControl,
                    .after = FaultClock::kFirstStep,
                    .begin = seconds(3),
                    .length = seconds(2)}};
  RobotBench bench(config);
  bench.session = 1;
  bench.steps = forward_steps(12);
  while (!bench.robot.faults().begun(0, bench.now)) bench.tick();
  const std::uint32_t started = bench.robot.control().pattern().started();
  bench.session = 0;  // the master says nothing more
  const int heard = bench.master.statuses;
  bench.run(1.9);
  EXPECT_EQ(bench.master.statuses, heard) << "nothing is said meanwhile";
  bench.run(10);
  EXPECT_GT(bench.master.statuses, heard);
  EXPECT_FALSE(bench.robot.fallen());
  EXPECT_EQ(bench.robot.control().pattern().phase(), nav::WalkingPattern::Phase::kStanding);
  EXPECT_GT(bench.robot.control().pattern().started(), started);
  EXPECT_LT(bench.robot.control().pattern().started(), 12U);
  EXPECT_EQ(bench.master.status.session, 0);
  EXPECT_EQ(bench.master.status.seq_accepted, bus::WalkStatus::kSeqAcceptedNone);
  EXPECT_EQ(bench.master.status.seq_executing, bus::WalkStatus::kSeqExecutingNone);
}

TEST(SimRobot, RefusesEveryStepWhenItsPlanSaysSo) {
  RobotConfig config;
  config.faults = {{.kind = FaultKind::kRejectingControl, .length = seconds(3)}};
  RobotBench bench(config);
  bench.session = 1;
  bench.steps = forward_steps(4);
  bench.run(2.9);
  EXPECT_EQ(bench.robot.path_walked(), 0);
  EXPECT_EQ(bench.master.status.reject_reason, bus::WalkStatus::RejectReason::kState);
  bench.run(8);
  EXPECT_GT(bench.robot.path_walked(), 0.5) << "and takes them again afterwards";
}

std::uint64_t hash_of_a_run(std::uint64_t seed) {
  RobotConfig config;
  config.body.seed = seed;
  config.faults = {
      {.kind = FaultKind::kCanLoss, .begin = seconds(1), .length = seconds(0.3), .share = 0.5, .id = 0x130}};
  RobotBench bench(config);
  bench.session = 4;
  bench.steps = forward_steps(6);
  std::uint64_t hash = 1469598103934665603U;
  const auto mix = [&](const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      hash = (hash ^ static_cast<const std::uint8_t*>(data)[i]) * 1099511628211U;
  };
  for (int i = 0; i < 1500; ++i) {
    bench.tick();
    const Eigen::Matrix4d pose = bench.robot.map_from_camera().matrix();
    mix(pose.data(), sizeof(double) * 16);
  }
  for (const hal::CanFrame& f : bench.master.frames) mix(f.data.data(), 8);
  return hash;
}

TEST(SimRobot, RunsTheSameForTheSameSeed) {
  EXPECT_EQ(hash_of_a_run(1), hash_of_a_run(1));
  EXPECT_NE(hash_of_a_run(1), hash_of_a_run(2));
}

TEST(SimRobot, RefusesAConfigurationThatCannotBe) {
  RobotConfig config;
  config.tilt.node = config.pan.node;
  EXPECT_THROW(SimRobot(config, {}), InputError);
  config = {};
  config.frame_rate = -1;
  EXPECT_THROW(SimRobot(config, {}), InputError);
  config = {};
  config.faults = {{.kind = FaultKind::kCanLoss, .share = 1.5}};
  EXPECT_THROW(SimRobot(config, {}), InputError);
  config = {};
  config.shape.torso_high = 0.1;
  EXPECT_THROW(SimRobot(config, {}), InputError);
}

}  // namespace
}  // namespace headway::sim
