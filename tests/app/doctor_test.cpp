#include "app/doctor.h"

#include <csignal>
#include <fstream>
#include <limits>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include "hal/angle.h"
#include "tests/app/run_headway.h"
#include "tests/drivers/pty.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

using testing::HasSubstr;

/// A machine made of files.
class MadeUpMachine {
 public:
  MadeUpMachine() {
    write("proc/sys/kernel/osrelease", "6.1.0-test");
    write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance");
    write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance");
    write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc");
    facts.root = folder_.path();
    facts.realtime_priority = 99;
    facts.locked_memory = std::uint64_t{1} << 30;
    facts.disk_free = std::uint64_t{1} << 34;
  }
  void write(const std::string& file, const std::string& line) const {
    std::filesystem::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << line << "\n";
  }
  Diagnosis examined() const {
    Diagnosis diagnosis;
    examine_machine(facts, wanted, diagnosis);
    return diagnosis;
  }
  /// The one finding that is not well.
  Finding complaint() const {
    const Diagnosis diagnosis = examined();
    Finding bad;
    int count = 0;
    for (const Finding& finding : diagnosis.findings()) {
      if (finding.verdict == Verdict::kOk) continue;
      bad = finding;
      ++count;
    }
    EXPECT_EQ(count, 1) << diagnosis.text();
    return bad;
  }

  MachineFacts facts;
  runtime::RealTime wanted;

 private:
  TemporaryFolder folder_;
};

TEST(Doctor, HasNothingToSayAgainstAGoodMachine) {
  const MadeUpMachine machine;
  EXPECT_EQ(machine.examined().worst(), Verdict::kOk) << machine.examined().text();
  EXPECT_EQ(machine.examined().json()["verdict"], "ok");
}

TEST(Doctor, SaysWhichLinesGiveRealTimeRights) {
  MadeUpMachine machine;
  machine.facts.realtime_priority = 0;
  const Finding bad = machine.complaint();
  EXPECT_EQ(bad.verdict, Verdict::kWarn) << "'run' starts all the same";
  EXPECT_THAT(bad.remedy, HasSubstr("rtprio 70"));
  EXPECT_THAT(bad.remedy, HasSubstr("LimitRTPRIO=70"));
  machine.wanted.want = runtime::RealTime::Want::kEnforce;
  machine.facts.locked_memory = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(machine.complaint().verdict, Verdict::kFail);
  machine.facts.root_user = true;
  EXPECT_EQ(machine.examined().worst(), Verdict::kOk);
}

TEST(Doctor, WarnsOfLittleLockedMemory) {
  MadeUpMachine machine;
  machine.facts.locked_memory = 8 << 20;
  EXPECT_THAT(machine.complaint().remedy, HasSubstr("memlock unlimited"));
}

using Want = runtime::RealTime::Want;

TEST(Doctor, AsksForNoRightsThatTheRobotFileDoesNotWant) {
  MadeUpMachine machine;
  machine.facts.realtime_priority = machine.facts.locked_memory = 0;
  machine.facts.may_run_on = [](int) { return false; };
  machine.wanted = {.want = Want::kOff, .bus_processor = 99};
  EXPECT_EQ(machine.examined().worst(), Verdict::kOk) << machine.examined().text();
  EXPECT_THAT(machine.examined().text(), HasSubstr("not asked for (runtime: real_time: off)"));
}

TEST(Doctor, KnowsThatRunDoesNotStartWithoutAllMemoryWhereThatIsEnforced) {
  MadeUpMachine machine;
  machine.wanted.want = Want::kEnforce;
  EXPECT_EQ(machine.complaint().what, "locked memory");
  EXPECT_EQ(machine.complaint().verdict, Verdict::kFail);
  machine.facts.locked_memory = ~std::uint64_t{};
  EXPECT_EQ(machine.examined().worst(), Verdict::kOk);
}

TEST(Doctor, NamesAProcessorThatTheBusLoopCannotHave) {
  MadeUpMachine machine;
  machine.facts.locked_memory = ~std::uint64_t{};
  machine.facts.may_run_on = [](int processor) { return processor < 2; };
  for (const auto& [want, verdict] :
       {std::pair(Want::kTry, Verdict::kWarn), std::pair(Want::kEnforce, Verdict::kFail)}) {
    machine.wanted = {.want = want, .bus_processor = 1};
    EXPECT_EQ(machine.examined().worst(), Verdict::kOk);
    machine.wanted.bus_processor = 2;
    EXPECT_EQ(machine.complaint().verdict, verdict);
    EXPECT_THAT(machine.complaint().found, HasSubstr("2 is refused"));
    EXPECT_THAT(machine.complaint().remedy, HasSubstr("bus_processor"));
  }
}

TEST(Doctor, TriesAProcessorOutAndLeavesTheThreadWhereItMayRun) {
  cpu_set_t before, after;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  const MachineFacts facts = MachineFacts::of_this_machine();
  for (int processor = 0; processor < CPU_SETSIZE; ++processor) {
    const bool is_ours = CPU_ISSET(static_cast<std::size_t>(processor), &before);
    EXPECT_TRUE(facts.may_run_on(processor) || !is_ours) << processor;
  }
  EXPECT_FALSE(facts.may_run_on(CPU_SETSIZE));
  ASSERT_EQ(sched_getaffinity(0, sizeof after, &after), 0);
  EXPECT_TRUE(CPU_EQUAL(&before, &after));
}

TEST(Doctor, WarnsOfAGovernorOfAnyProcessorThatSavesPower) {
  const MadeUpMachine machine;
  machine.write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave");
  EXPECT_THAT(machine.complaint().found, HasSubstr("powersave"));
}

TEST(Doctor, WarnsOfASlowClock) {
  const MadeUpMachine machine;
  machine.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  EXPECT_EQ(machine.complaint().found, "hpet");
}

TEST(Doctor, FailsOnAFullDisk) {
  MadeUpMachine machine;
  machine.facts.disk_free = 0;
  EXPECT_EQ(machine.complaint().verdict, Verdict::kFail);
  machine.facts.disk_free = std::uint64_t{1} << 30;
  EXPECT_EQ(machine.complaint().verdict, Verdict::kWarn);
}

TEST(Doctor, WarnsOfAHeadThatCanHardlyMove) {
  const auto text_of = [](double lowest_deg, double highest_deg) {
    Diagnosis diagnosis;
    hal::HeadLimits limits;
    limits.lower.tilt = lowest_deg * kDegree;
    limits.upper.tilt = highest_deg * kDegree;
    examine_head_limits(limits, diagnosis);
    return diagnosis.text();
  };
  EXPECT_EQ(text_of(-30, 45), "ok    head     limits: pan -45.0 to 45.0 deg, tilt -30.0 to 45.0 deg\n");
  EXPECT_THAT(text_of(-0.5, 0.78),
              HasSubstr("warn  head     limits: pan -45.0 to 45.0 deg, tilt -0.5 to 0.8 deg"));
  EXPECT_THAT(text_of(-0.5, 0.78), HasSubstr("degrees, not radians"));
}

TEST(Doctor, WritesALineForEachFindingAndItsRemedyBelow) {
  Diagnosis diagnosis("bus");
  diagnosis.ok("state", "error active");
  diagnosis.fail("drives", "none answers", "switch the head on");
  EXPECT_EQ(diagnosis.text(),
            "ok    bus      state: error active\n"
            "fail  bus      drives: none answers\n"
            "                 switch the head on\n");
  EXPECT_EQ(diagnosis.json()["findings"][1]["remedy"], "switch the head on");
}

/// Of the shipped robot, whose bus is not there: nothing is waited for.
test::Outcome doctor(const std::filesystem::path& robot, const std::filesystem::path& json) {
  return test::run_headway(
      {"doctor", robot.string(), "--bus", "slcan:/nowhere/tty", "--json", json.string()});
}

TEST(DoctorCommand, WritesItsVerdictOverNothingButItsOwn) {
  const TemporaryFolder folder;
  const std::string robot = read_text(source_dir() / "config/hrp2/robot.yaml");
  std::filesystem::copy(source_dir() / "config/hrp2/rigs", folder / "rigs");
  write_text(folder / "robot.yaml", robot);
  write_text(folder / "other.json", "{\"verdict\": \"ok\"}\n");
  std::filesystem::create_symlink(folder / "robot.yaml", folder / "link.json");
  for (const char* name : {"robot.yaml", "link.json", "rigs/bottom.yaml", "other.json"}) {
    const std::string before = read_text(folder / name);
    EXPECT_TRUE(test::says(doctor(folder / "robot.yaml", folder / name), {"--json: ", name, "expected"}));
    EXPECT_EQ(read_text(folder / name), before) << name;
  }
  write_text(folder / "found.json", "");
  for (int i = 0; i < 3; ++i) {
    const test::Outcome outcome = doctor(folder / "robot.yaml", folder / "found.json");
    EXPECT_EQ(outcome.code, kNotReached) << outcome.error;
    EXPECT_EQ(Json::parse(read_text(folder / "found.json"))["verdict"], "fail");
  }
}

TEST(DoctorCommand, LeavesTheErrorInPlaceOfAnEarlierVerdict) {
  const TemporaryFolder folder;
  doctor(source_dir() / "config/hrp2/robot.yaml", folder / "found.json");
  const test::Outcome outcome = doctor(folder / "absent.yaml", folder / "found.json");
  EXPECT_EQ(outcome.code, kBadInput);
  const Json found = Json::parse(read_text(folder / "found.json"));
  EXPECT_EQ(found["verdict"], "fail");
  EXPECT_EQ("headway: " + found["error"].get<std::string>() + "\n", outcome.error);
}

TEST(DoctorCommand, WritesItsVerdictOnceWhereItGoesToItsOwnOutput) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("/proc/self/fd/1", folder / "stdout");
  const std::string said = doctor(source_dir() / "config/hrp2/robot.yaml", folder / "stdout").said;
  EXPECT_THAT(said, testing::StartsWith("ok    machine  kernel"));
  EXPECT_EQ(Json::parse(said.substr(said.find("\n{") + 1))["verdict"], "fail");
}

TEST(DoctorCommand, EndsInOrderOnCtrlCAndSaysSo) {
  using drivers::testing::Deadline, drivers::testing::Pty;
  const TemporaryFolder folder;
  Pty pty;
  std::jthread adapter([&] {
    const Deadline deadline(std::chrono::seconds(20));
    std::string heard;
    while (heard.find("O\r") == std::string::npos && !deadline.passed()) heard += pty.read(1, deadline);
    kill(getpid(), SIGINT);
  });
  const auto outcome =
      test::run_headway({"doctor", (source_dir() / "config/hrp2/robot.yaml").string(), "--bus",
                         "slcan:" + pty.path(), "--json", (folder / "found.json").string()});
  EXPECT_EQ(outcome.code, kNotReached);
  EXPECT_THAT(outcome.said, HasSubstr("ok    bus      opened: slcan:"));
  EXPECT_THAT(outcome.said, HasSubstr("fail  doctor   interrupted: not all was looked at"));
  EXPECT_THAT(outcome.said, testing::Not(HasSubstr("pan drive"))) << "no verdict on what was not looked at";
  EXPECT_EQ(Json::parse(read_text(folder / "found.json"))["findings"].back()["what"], "interrupted");
}

}  // namespace
}  // namespace headway::app
