// The doctor at the simulated robot's bus, and at cameras that are made up.
#include "app/examine_wires.h"

#include <array>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "app/node_session.h"
#include "app/other_master.h"
#include "hal/angle.h"
#include "hal/error.h"
#include "sim_hal/robot.h"
#include "tests/drivers/scripted_camera.h"
#include "tests/source_dir/source_dir.h"

namespace headway::app {
namespace {

using testing::HasSubstr;

sim::World floor_only() {
  sim::World world;
  world.name = "floor";
  world.floor = {{0, 0}, {4, 4}};
  return world;
}

/// The robot behind its bus; it moves as the clock does.
struct Patient final : hal::CanBus {
  bool send(const hal::CanFrame& frame) noexcept override { return !cut && node.bus().send(frame); }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override {
    node.catch_up(clock.now());
    return cut ? 0 : node.bus().receive(into);
  }
  hal::CanBusState state() const noexcept override { return wire_state; }

  Diagnosis examined(bool tells_state = true) {
    Diagnosis diagnosis;
    examine_bus(
        robot, *this, clock, seconds(4), diagnosis, [] { return false; }, tells_state);
    return diagnosis;
  }

  hal::ManualClock clock;
  Robot robot = read_robot(source_dir() / "config/hrp2/robot.yaml");
  NodeSession node{robot, floor_only(), {}, true, clock.now()};
  bool cut = false;
  hal::CanBusState wire_state = hal::CanBusState::kErrorActive;
};

TEST(ExamineBus, FindsAWellRobotWell) {
  Patient patient;
  const Diagnosis diagnosis = patient.examined();
  EXPECT_EQ(diagnosis.worst(), Verdict::kOk) << diagnosis.text();
  EXPECT_THAT(diagnosis.text(), HasSubstr("pan drive, node 0x11: runs; Sim\n"));
  EXPECT_THAT(diagnosis.text(), HasSubstr("clock: is 0.00")) << "it began with ours";
  EXPECT_THAT(diagnosis.text(), HasSubstr("give or take"));
  EXPECT_EQ(patient.node.body().path_walked(), 0) << "the doctor walks nobody";
}

/// Emergency messages that are heard within a second.
int emergencies(Patient& patient) {
  std::array<hal::CanFrame, 32> frames;
  int count = 0;
  for (const Time end = patient.clock.now() + seconds(1); patient.clock.now() < end;) {
    patient.clock.advance(seconds(0.005));
    const std::size_t heard = patient.receive(frames);
    for (const hal::CanFrame& frame : std::span(frames).first(heard))
      count += frame.id == 0x091 || frame.id == 0x092;
  }
  return count;
}

TEST(ExamineBus, LeavesDrivesThatHoldAndMissNobody) {
  Patient patient;
  patient.examined();
  EXPECT_EQ(emergencies(patient), 0);
  const Diagnosis again = patient.examined();
  EXPECT_EQ(again.worst(), Verdict::kOk) << again.text();
  EXPECT_THAT(again.text(), HasSubstr("tilt drive, node 0x12: runs; was held by a quick stop before"));
}

TEST(ExamineBus, EndsInTheSameOrderAndWithoutAVerdictWhenItIsAskedTo) {
  // While it listens for others, sets the drives up, and has them running.
  for (const double after : {0.1, 1.3, 3.0}) {
    Patient patient;
    const Time begin = patient.clock.now();
    Diagnosis diagnosis;
    examine_bus(patient.robot, patient, patient.clock, seconds(4), diagnosis,
                [&] { return patient.clock.now() - begin > seconds(after); });
    EXPECT_TRUE(diagnosis.findings().empty()) << diagnosis.text();
    EXPECT_LT(patient.clock.now() - begin, seconds(after + 1.2));
    EXPECT_EQ(emergencies(patient), 0) << after;
  }
}

/// A robot whose tilt drive does not know where its joint is.
sim::RobotConfig unhomed() {
  sim::RobotConfig config;
  config.tilt.homed = false;
  config.tilt.start_angle = 0.2;
  return config;
}

/// A robot whose tilt drive stands 5 degrees beyond its limit.
sim::RobotConfig outside() {
  sim::RobotConfig config;
  config.tilt.start_angle = 50 * kDegree;
  return config;
}

/// A robot that stands in the way that was told, and moves as the clock does.
struct HeadOnly final : hal::CanBus {
  explicit HeadOnly(const sim::RobotConfig& config) : body(config, Pose2{}) {}
  bool send(const hal::CanFrame& frame) noexcept override { return body.bus().send(frame); }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override {
    while (stepped + sim::SimRobot::kPeriod <= clock.now()) body.step(stepped += sim::SimRobot::kPeriod);
    return body.bus().receive(into);
  }
  hal::CanBusState state() const noexcept override { return body.bus().state(); }

  hal::ManualClock clock;
  Time stepped{};
  mutable sim::SimRobot body;
};

TEST(ExamineBus, MovesNoHeadThatStandsOutsideItsLimits) {
  for (const auto mode : {drivers::SetPointMode::kProfile, drivers::SetPointMode::kCyclic}) {
    HeadOnly patient(outside());
    Robot robot = read_robot(source_dir() / "config/hrp2/robot.yaml");
    robot.hardware.set_points = mode;
    const double before = patient.body.head().tilt;
    Diagnosis diagnosis;
    examine_bus(robot, patient, patient.clock, seconds(4), diagnosis);
    EXPECT_THAT(diagnosis.text(), HasSubstr("tilt drive, node 0x12: stands outside its limits"));
    EXPECT_THAT(diagnosis.text(), HasSubstr("turn the head inside by hand"));
    EXPECT_NEAR(patient.body.head().tilt, before, 1e-9);
  }
}

TEST(ExamineBus, MovesNoHeadThatIsNotHomedEvenWhereThatMayMoveByItself) {
  HeadOnly patient(unhomed());
  Robot robot = read_robot(source_dir() / "config/hrp2/robot.yaml");
  robot.hardware.homing.policy = drivers::HomingConfig::Policy::kMove;
  robot.hardware.homing.method = 17;
  Diagnosis diagnosis;
  examine_bus(robot, patient, patient.clock, seconds(4), diagnosis);
  EXPECT_THAT(diagnosis.text(), HasSubstr("tilt drive, node 0x12: does not know where its joint is"));
  EXPECT_NEAR(patient.body.head().tilt, 0.2, 1e-9);
}

TEST(ExamineBus, SaysThatNothingIsHeardWhereTheWireIsCut) {
  Patient patient;
  patient.cut = true;
  const std::string text = patient.examined().text();
  EXPECT_THAT(text, HasSubstr("fail  bus      load: nothing was heard"));
  EXPECT_THAT(text, HasSubstr("tilt drive, node 0x12: does not answer so far"));
  EXPECT_THAT(text, HasSubstr("control computer: is not heard"));
  EXPECT_THAT(text, HasSubstr("60 ohms"));
}

TEST(ExamineBus, FailsABusThatIsOff) {
  Patient patient;
  patient.wire_state = hal::CanBusState::kBusOff;
  EXPECT_THAT(patient.examined().text(), HasSubstr("fail  bus      state: off the bus"));
}

TEST(ExamineBus, BlamesAnAdapterThatIsGoneAndNothingElse) {
  Patient patient;
  patient.cut = true;
  patient.wire_state = hal::CanBusState::kGone;
  const std::string text = patient.examined().text();
  EXPECT_THAT(
      text,
      HasSubstr("fail  bus      state: gone; 0 frames heard\n                 the adapter was unplugged"));
  EXPECT_THAT(text, HasSubstr("fail  head     drives: not looked at to the end: the adapter went away"));
  EXPECT_THAT(text, HasSubstr("fail  walker   control computer: not looked at to the end: the adapter"));
  for (const char* wrong : {"60 ohms", "node number", "start its program"})
    EXPECT_THAT(text, testing::Not(HasSubstr(wrong)));
}

TEST(ExamineBus, MakesUpNoStateThatAnAdapterDoesNotTell) {
  Patient silent, well;
  silent.cut = true;
  const std::string text = silent.examined(false).text();
  EXPECT_THAT(text, HasSubstr("ok    bus      state: not told by an adapter of this kind; 0 frames heard"));
  EXPECT_THAT(text, HasSubstr("load: nothing was heard\n                 is it an adapter of this kind"));
  EXPECT_THAT(text, testing::Not(HasSubstr("error active")));
  EXPECT_EQ(well.examined(false).worst(), Verdict::kOk);
}

/// The robot's wire, with a second control computer on it that began a little before.
struct TwoComputers final : hal::CanBus {
  bool send(const hal::CanFrame& frame) noexcept override { return first.send(frame); }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override {
    second.catch_up(first.clock.now());
    std::size_t count = first.receive(into);
    std::array<hal::CanFrame, 1> frame;
    while (count < into.size() && second.bus().receive(frame) == 1)
      if (frame[0].id >= 0x130 && frame[0].id <= 0x140) into[count++] = frame[0];
    return count;
  }
  hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }

  Patient first;
  NodeSession second{first.robot, floor_only(), {}, true, first.clock.now() - seconds(0.07)};
};

TEST(ExamineBus, SuspectsASecondControlComputerWhereAllButTheOrderIsRight) {
  TwoComputers wire;
  Diagnosis diagnosis;
  examine_bus(wire.first.robot, wire, wire.first.clock, seconds(4), diagnosis);
  EXPECT_THAT(diagnosis.text(), HasSubstr("warn  walker   frames: 0 with a wrong CRC"));
  EXPECT_THAT(diagnosis.text(), HasSubstr("is there another control computer"));
  EXPECT_THAT(diagnosis.text(), testing::Not(HasSubstr("headway.dbc")));
}

/// The wire, on which somebody else commands as well.
struct SharedWire final : hal::CanBus {
  explicit SharedWire(Patient& its_patient) : patient(its_patient) {}
  bool send(const hal::CanFrame&) noexcept override {
    ++sent;
    return true;
  }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override {
    if (patient.clock.now() - began < seconds(0.3) || told) return patient.receive(into);
    told = true;
    into[0] = others;
    return 1;
  }
  hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }

  Patient& patient;
  Time began = patient.clock.now();
  hal::CanFrame others;
  bool told = false;
  int sent = 0;
};

TEST(ExamineBus, SendsNothingWhereAnotherMasterIsHeard) {
  for (const std::uint32_t id : {0x000u, 0x080u, 0x701u, 0x120u, 0x121u, 0x122u, 0x211u, 0x612u}) {
    Patient patient;
    SharedWire wire(patient);
    wire.others = {.id = id, .dlc = 0, .data = {}, .stamp = {}};
    Diagnosis diagnosis;
    examine_bus(patient.robot, wire, patient.clock, seconds(4), diagnosis);
    EXPECT_EQ(wire.sent, 0) << id;
    ASSERT_EQ(diagnosis.findings().size(), 1u) << diagnosis.text();
    EXPECT_EQ(diagnosis.worst(), Verdict::kFail);
    EXPECT_THAT(diagnosis.text(), HasSubstr(fmt::format("(0x{:03X}) is heard", id)));
  }
}

TEST(ExamineBus, TakesNoFrameOfTheRobotItselfForAMaster) {
  for (const std::uint32_t id :
       {0x091u, 0x130u, 0x131u, 0x132u, 0x140u, 0x191u, 0x292u, 0x592u, 0x711u, 0x712u})
    EXPECT_FALSE(word_of_a_master({.id = id, .dlc = 0, .data = {}, .stamp = {}})) << id;
}

/// What the program says that finds this on the bus before it begins; empty when it begins.
std::string refusal(void (*listen)(hal::CanBus&, hal::Clock&), std::uint32_t id) {
  Patient patient;
  patient.cut = true;
  SharedWire wire(patient);
  wire.others = {.id = id, .dlc = 0, .data = {}, .stamp = {}};
  std::string said;
  try {
    listen(wire, patient.clock);
  } catch (const Error& refused) {
    said = refused.what();
  }
  EXPECT_EQ(wire.sent, 0);
  return said;
}

TEST(OtherMaster, KeepsAnotherRunFromBeginningAndTheRobotDoesNot) {
  for (const std::uint32_t id : {0x000u, 0x080u, 0x701u, 0x121u, 0x211u, 0x612u}) {
    EXPECT_THAT(refusal(refuse_other_master, id),
                HasSubstr(fmt::format("(0x{:03X}) is heard on the bus", id)));
    EXPECT_THAT(refusal(refuse_other_master, id), HasSubstr("end 'headway run'"));
    EXPECT_EQ(refusal(refuse_other_robot, id), "") << "it is there to lead this robot";
  }
}

TEST(OtherMaster, KeepsASimulatedRobotFromJoiningAnother) {
  for (const std::uint32_t id : {0x130u, 0x711u, 0x712u}) {
    EXPECT_THAT(refusal(refuse_other_robot, id),
                HasSubstr(fmt::format("(0x{:03X}) is heard on the bus", id)));
    EXPECT_THAT(refusal(refuse_other_robot, id), HasSubstr("a bus of its own"));
    EXPECT_EQ(refusal(refuse_other_master, id), "") << "that is whom it leads";
  }
}

TEST(ExamineExposures, WarnsOfAnAutomaticThatMaySlowACameraDown) {
  const hal::ManualClock clock;
  drivers::testing::ScriptedCalls calls(clock);
  calls.add("/dev/left", drivers::testing::ScriptedCamera(drivers::PixelFormat::kGrey));
  auto& right = calls.add("/dev/right", drivers::testing::ScriptedCamera(drivers::PixelFormat::kGrey));
  right.controls[V4L2_CID_EXPOSURE_AUTO].value = V4L2_EXPOSURE_MANUAL;
  std::vector<EyeLook> eyes(3);
  eyes[0].name = "left", eyes[0].path = "/dev/left";
  eyes[1].name = "right", eyes[1].path = "/dev/right";
  eyes[2].path = "/dev/gone";
  Diagnosis diagnosis;
  examine_exposures(eyes, calls, diagnosis);
  ASSERT_EQ(diagnosis.findings().size(), 2u);
  EXPECT_THAT(diagnosis.text(),
              HasSubstr("warn  eyes     left exposure: 25.0 ms, automatic: in the dark it may"));
  EXPECT_THAT(diagnosis.text(), HasSubstr("exposure_ms"));
  EXPECT_THAT(diagnosis.text(), HasSubstr("ok    eyes     right exposure: 25.0 ms, by hand"));
}

CameraLook two_good_eyes() {
  CameraLook look;
  for (const char* name : {"left", "right"}) {
    EyeLook eye;
    eye.name = name;
    eye.stats.state = hal::CameraState::kStreaming;
    eye.rate = 15;
    look.eyes.push_back(eye);
  }
  look.pair.emplace();
  look.pair->state = hal::CameraState::kStreaming;
  look.pair->rate = 15;
  look.pair->exposure_gap = Duration{};
  return look;
}

Diagnosis examined(const CameraLook& look) {
  Diagnosis diagnosis;
  examine_cameras(look, {}, diagnosis);
  return diagnosis;
}

TEST(ExamineCameras, FindsGoodEyesWell) {
  EXPECT_EQ(examined(two_good_eyes()).worst(), Verdict::kOk) << examined(two_good_eyes()).text();
}

TEST(ExamineCameras, NamesTheEyeThatIsGoneSlowOrOutOfStep) {
  CameraLook gone = two_good_eyes();
  gone.eyes[1].stats.state = hal::CameraState::kGone;
  EXPECT_EQ(examined(gone).worst(), Verdict::kFail);
  EXPECT_THAT(examined(gone).text(), HasSubstr("fail  eyes     right camera: gone"));
  CameraLook slow = two_good_eyes();
  slow.eyes[0].rate = 7.5;
  EXPECT_EQ(examined(slow).worst(), Verdict::kWarn);
  EXPECT_THAT(examined(slow).text(), HasSubstr("left camera: streaming, 7.5 frames/s"));
  CameraLook apart = two_good_eyes();
  apart.pair->exposure_gap = seconds(0.004);
  EXPECT_THAT(examined(apart).text(), HasSubstr("right +4.2 ms after left"));
  EXPECT_EQ(examined(apart).worst(), Verdict::kWarn);
  apart.pair->exposure_gap.reset();
  EXPECT_THAT(examined(apart).text(), HasSubstr("right more than 5 ms after left"));
  EXPECT_EQ(examined(apart).worst(), Verdict::kWarn);
}

}  // namespace
}  // namespace headway::app
