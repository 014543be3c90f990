// The frame loop between eyes that show what a test wants, and a bus loop with a robot that walks.
#include "runtime/frame_loop.h"

#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/bus_loop.h"
#include "runtime/lockstep.h"
#include "tests/runtime/fake_robot.h"
#include "tests/runtime/flat_room.h"

namespace headway::runtime {
namespace {

constexpr double kFrame = 0.1;  // [s]

hal::HeadKinematics neck() {
  hal::HeadKinematics k;
  k.chest_from_pan.translation().z() = 0.4;
  k.tilt_from_camera.linear() = hal::body_from_optical();
  return k;
}

/// A frame every 0.1 s, taken by the head as it is, covered or faulty on demand; a faulty one shows points
/// too.
class FakeEyes final : public Eyes {
 public:
  FakeEyes(const hal::Clock& clock, const FakeHead& head, const FakeWalker& walker)
      : clock_(clock), head_(head), walker_(walker) {}

  std::optional<FrameStamp> take() override {
    if (silent || clock_.now() < next_) return std::nullopt;
    next_ = clock_.now() + period;
    exposure_ = clock_.now() - late;
    pose_ = truth(walker_.chest().odom_from_chest) * neck().chest_from_camera(head_.state().position);
    return FrameStamp{exposure_, sequence_++};
  }
  const vision::RangeView& see() override {
    view_ = look(boxes, pose_, covered);
    return view_;
  }
  Eigen::Isometry3d left_from_view() const override { return Eigen::Isometry3d::Identity(); }
  const std::string& fault() const override { return fault_; }
  void break_down(std::string fault) { fault_ = std::move(fault); }

  /// Where the chest really is.
  Eigen::Isometry3d truth(Eigen::Isometry3d odom_from_chest) const {
    odom_from_chest.translation().x() *= stride;
    return odom_from_chest;
  }

  void look_with(const Effort& wanted) override { effort = wanted; }

  bool covered = false, silent = false;
  Duration period = seconds(kFrame);
  Effort effort;    ///< of the newest frame
  Duration late{};  ///< of the exposure behind its delivery
  Boxes boxes;
  double stride = 1;  ///< true length of a way along x over that which odometry tells

 private:
  const hal::Clock& clock_;
  const FakeHead& head_;
  const FakeWalker& walker_;
  std::string fault_;
  Time next_{}, exposure_{};
  std::uint64_t sequence_ = 0;
  Eigen::Isometry3d pose_;
  vision::RangeView view_;
};

MissionConfig mission_config() {
  MissionConfig config;
  config.neck = neck();
  config.viewpoints = {{0, 0.5}, {0.6, 0.5}, {-0.6, 0.5}, {0, 0.1}};
  return config;
}

struct Robot {
  hal::ManualClock clock;
  SilentBus bus;
  FakeHead head;
  FakeWalker walker;
  Links links;
  FakeEyes eyes{clock, head, walker};
  Mapper mapper{small_map(), {}};
  Mission mission{mission_config(), mapper.floor().grid};
  BusLoop bus_loop{{.stance = hal::Stance::parallel({}, 0.19), .steps = {}}, bus, head, walker, links};
  FrameLoop frames{{.neck = neck()}, eyes, mapper, mission, links, clock};
  Lockstep lockstep{{.charge = {.see = seconds(0.05)}}, clock, [](Time) {}, bus_loop, frames};

  void run(double s) {
    for (const Time end = clock.now() + seconds(s); clock.now() < end;) lockstep.step();
  }
  void run_until_over() {
    for (int i = 0; i < 60 && !mission.over(); ++i) run(1);
  }
  const BusReport& report() const { return links.report.value(); }
};

/// Under way to a goal 3 m ahead, some steps walked.
struct WalkingRobot : Robot {
  WalkingRobot() {
    mission.set_goal({{3, 0}, std::nullopt});
    for (int i = 0; i < 300 && walker.stance.base().x < 0.3; ++i) run(0.1);
  }
  /// What becomes of the walk within the time after which steps may no longer rest on the last frame, and the
  /// time that the committed ones take.
  void expect_rest_before_long() {
    ASSERT_EQ(report().safety.state, SafetyState::kActive);
    const auto sent = walker.sent_count;
    run(1.5);
    EXPECT_LE(walker.sent_count, sent + 2) << "no step rests on a map older than a second";
    run(3);
    EXPECT_TRUE(report().committed.at_rest);
    EXPECT_EQ(report().last_stop, nav::StackStop::kStale);
    EXPECT_LT(walker.stance.base().x, 2);
  }
};

TEST(FrameLoop, TellsTheMissionWhenNoPictureComesAnyMore) {
  WalkingRobot robot;
  robot.eyes.silent = true;
  robot.expect_rest_before_long();
  EXPECT_EQ(robot.mission.state(), MissionState::kStopped);
  EXPECT_NE(robot.mission.reason().find("stopped for safety: pictures too old; no picture comes"),
            std::string::npos)
      << robot.mission.reason();
}

TEST(FrameLoop, LooksMapsAndWalksToTheGoal) {
  WalkingRobot robot;
  ASSERT_EQ(robot.mission.state(), MissionState::kWalk) << robot.mission.reason();
  robot.run(25);
  EXPECT_EQ(robot.mission.state(), MissionState::kArrived) << robot.mission.reason();
  EXPECT_NEAR(robot.walker.stance.base().x, 3, 0.07);
  EXPECT_EQ(robot.frames.counters().unusable, 0U);
  EXPECT_EQ(robot.frames.counters().no_pose, 0U);
}

TEST(FrameLoop, ComesToRestSoonWhenTheLensIsCovered) {
  WalkingRobot robot;
  ASSERT_EQ(robot.mission.state(), MissionState::kWalk);
  robot.eyes.covered = true;
  robot.expect_rest_before_long();
  EXPECT_GE(robot.frames.counters().unusable, 40U);
}

TEST(FrameLoop, ComesToRestSoonWhenTheEyesReportAFault) {
  WalkingRobot robot;
  ASSERT_EQ(robot.mission.state(), MissionState::kWalk);
  robot.eyes.break_down("the images have no pixels");
  robot.expect_rest_before_long();
  EXPECT_EQ(robot.mission.state(), MissionState::kStopped);
  EXPECT_NE(robot.mission.reason().find("pictures too old; the images have no pixels"), std::string::npos)
      << robot.mission.reason();
}

TEST(FrameLoop, KeepsWhatAFaultyPairShowsOutOfTheMap) {
  Robot robot;
  robot.eyes.break_down("the left camera is covered");
  robot.run(1);
  ASSERT_GE(robot.frames.counters().frames, 9U);
  const nav::VoxelMap& map = robot.mapper.voxels();
  std::size_t seen = 0;
  for (std::size_t b = 0; b < map.brick_count(); ++b) seen += map.summary(b).changed != nav::kNever;
  EXPECT_EQ(seen, 0U);
  robot.eyes.break_down("");
  robot.run(1);
  for (std::size_t b = 0; b < map.brick_count(); ++b) seen += map.summary(b).changed != nav::kNever;
  EXPECT_GT(seen, 0U);
}

TEST(FrameLoop, WalksOnWhenItSeesAgain) {
  WalkingRobot robot;
  robot.eyes.covered = true;
  robot.run(5);
  ASSERT_TRUE(robot.report().committed.at_rest);
  robot.eyes.covered = false;
  robot.run(30);
  EXPECT_EQ(robot.mission.state(), MissionState::kArrived) << robot.mission.reason();
}

TEST(FrameLoop, WalksOnAfterAGapInThePicturesButNotAfterALongOne) {
  for (const auto& [gap, frozen] : {std::pair(1.5, false), {4.0, false}, {1.5, true}, {4.0, true}}) {
    WalkingRobot robot;
    robot.eyes.silent = !frozen;
    if (frozen) robot.eyes.break_down(kFrozen);
    robot.run(gap);
    robot.eyes.silent = false;
    robot.eyes.break_down("");
    robot.run_until_over();
    EXPECT_EQ(robot.mission.state(), gap < 3 ? MissionState::kArrived : MissionState::kStopped)
        << robot.mission.reason();
    if (gap < 3) continue;
    const double x = robot.walker.stance.base().x;
    EXPECT_LT(x, 2);
    robot.run(5);
    EXPECT_EQ(robot.walker.stance.base().x, x) << "not by itself";
    robot.mission.set_goal({{3, 0}, std::nullopt});
    robot.run_until_over();
    EXPECT_EQ(robot.mission.state(), MissionState::kArrived) << robot.mission.reason();
  }
}

TEST(FrameLoop, SkipsAFrameWhosePoseIsNotKnown) {
  Robot robot;
  robot.run(1);
  const auto used = robot.frames.counters().frames;
  robot.eyes.late = seconds(5);  // exposed before the robot was switched on
  robot.run(1);
  EXPECT_GE(robot.frames.counters().no_pose, 9U);
  EXPECT_LE(robot.frames.counters().frames, used + 1);
}

TEST(FrameLoop, ComesFromTheCamerasTimeToTheBussByTheOffsetThatItIsGiven) {
  Robot robot;
  robot.eyes.late = seconds(5);
  FrameLoop frames({.neck = neck(), .camera_time_offset = seconds(5)}, robot.eyes, robot.mapper,
                   robot.mission, robot.links, robot.clock);
  Lockstep lockstep(
      {.charge = {.see = seconds(0.05)}}, robot.clock, [](Time) {}, robot.bus_loop, frames);
  for (int i = 0; i < 400; ++i) lockstep.step();
  EXPECT_GE(frames.counters().frames, 15U);
  EXPECT_EQ(frames.counters().no_pose, 0U);
}

TEST(FrameLoop, DoesLessWithEachFrameWhileItIsLateAndAllOfItAgainWhenThereIsTime) {
  Robot robot;
  const Duration period = seconds(1.0 / 30);
  robot.eyes.period = period;
  FrameLoop frames({.neck = neck(), .budget = {.period = period}}, robot.eyes, robot.mapper, robot.mission,
                   robot.links, robot.clock);
  std::vector<FrameLevel> levels;
  frames.observe([&](const FrameSnapshot&) {
    if (levels.empty() || levels.back() != frames.level()) levels.push_back(frames.level());
    EXPECT_EQ(robot.eyes.effort.half, frames.level() >= FrameLevel::kHalfResolution);
    EXPECT_EQ(robot.eyes.effort.farthest < 100, frames.level() == FrameLevel::kNear);
  });
  const auto run = [&](const StageTimes& stages, double s) {
    Lockstep lockstep(
        {.charge = stages}, robot.clock, [](Time) {}, robot.bus_loop, frames);
    for (const Time end = robot.clock.now() + seconds(s); robot.clock.now() < end;) lockstep.step();
  };
  const StageTimes ordinary{seconds(0.015), seconds(0.004), seconds(0.001), seconds(0.004)};
  const StageTimes slow{seconds(0.120), seconds(0.040), seconds(0.010), seconds(0.010)};
  robot.mission.set_goal({{3, 0}, std::nullopt});
  run(ordinary, 6);
  EXPECT_EQ(levels, (std::vector<FrameLevel>{FrameLevel::kFull}));
  EXPECT_EQ(frames.counters().late + frames.counters().left_out, 0U);
  run(slow, 8);
  EXPECT_EQ(levels, (std::vector{FrameLevel::kFull, FrameLevel::kEveryOther, FrameLevel::kHalfResolution,
                                 FrameLevel::kNear}));
  EXPECT_EQ(frames.counters().late, 9U) << "three frames at each level; the last one does";
  run(ordinary, 12);
  EXPECT_EQ(frames.level(), FrameLevel::kFull);
  EXPECT_GT(frames.counters().left_out, 10U);
  for (int i = 0; i < 20 && !robot.mission.over(); ++i) run(ordinary, 1);
  EXPECT_EQ(robot.mission.state(), MissionState::kArrived) << robot.mission.reason();
  int steps = 0;
  for (StepRecord step; robot.links.steps.pop(step); ++steps)
    EXPECT_LE(step.frame_age, nav::StepStackConfig{}.max_map_age);
  EXPECT_GT(steps, 10);
}

TEST(FrameLoop, HandsOverAPlanTooLateForItsFirstStepAndIsRefusedIt) {
  WalkingRobot robot;
  Lockstep slow(
      {.charge = {.see = seconds(0.9)}}, robot.clock, [](Time) {}, robot.bus_loop, robot.frames);
  for (int i = 0; i < 600; ++i) slow.step();
  EXPECT_GE(robot.bus_loop.counters().plans_late, 1U);
}

/// Where a robot whose strides are short by 5 % comes to rest that is sent 3 m ahead.
double place_reached(bool localise, LocalisationCounters& views) {
  Robot robot;
  robot.eyes.stride = 0.95;
  robot.eyes.boxes = {box(4.4, 4.8, -2.2, 2.2, 2), box(-1.4, 4.4, 2, 2.2, 2), box(-1.4, 4.4, -2.2, -2, 2)};
  FrameLoopConfig config{.neck = neck()};
  config.localisation.use = localise;
  FrameLoop frames(config, robot.eyes, robot.mapper, robot.mission, robot.links, robot.clock);
  Lockstep lockstep(
      {.charge = {.see = seconds(0.05)}}, robot.clock, [](Time) {}, robot.bus_loop, frames);
  frames.observe([](const FrameSnapshot& frame) {
    const nav::Committed& committed = frame.bus.committed;
    if (committed.next_index == 0) return;
    const hal::Stance& last = committed.step(committed.next_index - 1)->stance;
    EXPECT_EQ(last.left.x, committed.stance.left.x) << "both in the map";
    EXPECT_EQ(last.right.y, committed.stance.right.y);
  });
  robot.mission.set_goal({{3, 0}, std::nullopt});
  for (int i = 0; i < 12000 && robot.mission.state() != MissionState::kArrived; ++i) lockstep.step();
  EXPECT_EQ(robot.mission.state(), MissionState::kArrived) << robot.mission.reason();
  views = frames.localisation().counters();
  return robot.walker.stance.base().x * robot.eyes.stride;
}

TEST(FrameLoop, ArrivesThoughOdometryDrifts) {
  LocalisationCounters with, without;
  EXPECT_NEAR(place_reached(true, with), 3, 0.06);
  EXPECT_LT(place_reached(false, without), 2.90) << "or there was nothing to find";
  EXPECT_GT(with.whole + with.partly, 50U);
  EXPECT_EQ(without.whole + without.partly + without.refused, 0U);
}

/// A camera that delivers one frame of a size.
class OneDepthFrame final : public hal::DepthCamera {
 public:
  OneDepthFrame(int width, int height, std::size_t pixels)
      : width_(width), height_(height), pixels_(pixels) {}
  bool take_newest(hal::DepthFrame& into) override {
    into = {at_seconds(1), 1, width_, height_, std::vector<float>(pixels_, 2.0F)};
    return true;
  }

 private:
  int width_, height_;
  std::size_t pixels_;
};

std::string fault_of(int width, int height, std::size_t pixels) {
  OneDepthFrame camera(width, height, pixels);
  DepthEyes eyes(camera, {.camera = {8, 6, 5, 3.5, 2.5}, .sigma = vision::StereoDepthSigma{1, 0.01}});
  EXPECT_TRUE(eyes.take());
  const vision::RangeView& view = eyes.see();
  const bool points = std::any_of(view.depth.begin(), view.depth.end(), [](float z) { return z > 0; });
  EXPECT_EQ(points, eyes.fault().empty());
  return eyes.fault();
}

TEST(DepthEyes, NameAnImageOfAnotherSize) {
  EXPECT_EQ(fault_of(8, 6, 48), "");
  EXPECT_EQ(fault_of(6, 8, 48), "the depth image has 6 x 8 px, expected 8 x 6 px");
  EXPECT_NE(fault_of(8, 6, 47), "");
}

}  // namespace
}  // namespace headway::runtime
