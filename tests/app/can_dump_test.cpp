// headway can dump as a user calls it: from a log and from a bus, as text and as JSON.
#include <algorithm>
#include <cctype>
#include <csignal>
#include <sstream>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <rapidcheck.h>

#include "app/can_decoder.h"
#include "hal/bus_codec.h"
#include "tests/app/run_headway.h"
#include "tests/drivers/pty.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace bus = hal::bus;
using drivers::testing::Deadline, drivers::testing::Pty;
using test::Outcome, test::run_headway, test::says;
using testing::AllOf, testing::HasSubstr, testing::Not;

/// A step of the robot with a counter and its CRC, as candump writes it.
std::string step_line(std::uint8_t counter, std::uint8_t damage = 0) {
  hal::CanFrame frame = *bus::StepCommand{.counter = counter, .seq = 5, .session = 2, .dx = 0.25}.pack();
  frame.data[0] = static_cast<std::uint8_t>(bus::frame_crc(frame, bus::StepCommand::kDataId) ^ damage);
  std::string text = "(12.5) can0 120#";
  for (const std::uint8_t byte : frame.data) text += fmt::format("{:02X}", byte);
  return text + "\n";
}

class CanDump : public testing::Test {
 protected:
  Outcome dump(const std::string& log, std::vector<std::string> more = {}) {
    write_text(folder_ / "a.log", log);
    std::vector<std::string> arguments{"can", "dump", "--log", (folder_ / "a.log").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_headway(arguments);
  }
  TemporaryFolder folder_;
};

TEST_F(CanDump, NamesMessagesAndValuesWithTheirUnits) {
  const Outcome outcome = dump("(1436509052.249713) can0 291#10270000F0D8FFFF\n");
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  EXPECT_EQ(outcome.said,
            "(1436509052.249713)  can0  291  [8]  10 27 00 00 F0 D8 FF FF  PAN_Tpdo2 (TPDO2 of node 0x11)"
            "  Position 10 deg  Velocity -10 deg/s\n");
  EXPECT_THAT(outcome.error, HasSubstr("1 frames: 0 unknown"));
}

TEST_F(CanDump, TellsWhichProtectedFramesMayNotBeUsed) {
  const Outcome outcome =
      dump(step_line(3) + step_line(4) + step_line(4) + step_line(6) + step_line(7, 0x40) + step_line(0));
  ASSERT_EQ(outcome.code, kSuccess);
  std::istringstream lines(outcome.said);
  for (const char* verdict :
       {"[ok]", "[ok]", "[repeated]", "[ok, some lost]", "[wrong CRC]", "[wrong sequence]"}) {
    std::string line;
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_THAT(line, AllOf(HasSubstr("VIS_StepCommand"), HasSubstr(verdict), HasSubstr("  Dx 0.25 m  ")));
  }
  EXPECT_THAT(outcome.error, HasSubstr("1 with a wrong CRC, 1 repeated, 1 out of sequence, 1 lost"));
}

TEST_F(CanDump, FollowsTheCountersOfEachBus) {
  std::string other = step_line(4);
  other.replace(other.find("can0"), 4, "can1");
  const Outcome outcome = dump(step_line(3) + other + step_line(4));
  EXPECT_THAT(outcome.said, Not(HasSubstr("repeated")));
  EXPECT_THAT(outcome.error,
              AllOf(HasSubstr("3 frames"), HasSubstr("0 repeated, 0 out of sequence, 0 lost")));
}

TEST_F(CanDump, NamesWhatTheContractDoesNotKnowByCanopen) {
  const Outcome outcome = dump("(1.0) can0 385#11\n(1.0) can0 123#22\n");
  EXPECT_THAT(outcome.said, AllOf(HasSubstr("unknown (TPDO3 of node 0x05)"),
                                  HasSubstr("22                       unknown\n")));
}

TEST_F(CanDump, SaysWhatIsNotAsDeclared) {
  const Outcome outcome = dump("(1.0) can0 711#0505\n(1.0) can0 711#06\n(1.0) can0 711#05\n");
  EXPECT_THAT(outcome.error, HasSubstr("2 not as declared"));
  EXPECT_THAT(outcome.said,
              AllOf(HasSubstr("PAN_Heartbeat (heartbeat of node 0x11) [not as the contract declares]\n"),
                    HasSubstr("PAN_Heartbeat (heartbeat of node 0x11)  State 5 (Operational)\n")));
}

TEST_F(CanDump, ShowsOtherKindsOfFramesWithoutAMeaning) {
  const Outcome outcome =
      dump("(1.0) can0 00000291#1027000000000000\n(1.0) can0 291#R8\n(1.0) can0 20000004#0008000000000000\n");
  EXPECT_THAT(outcome.said,
              AllOf(HasSubstr("00000291  [8]"), HasSubstr("29-bit identifier"), HasSubstr("291  [8]"),
                    HasSubstr("remote request"), HasSubstr("error frame"), Not(HasSubstr("Position"))));
  EXPECT_THAT(outcome.error, HasSubstr("3 frames: 0 unknown"));
}

TEST_F(CanDump, WritesOneObjectForEachFrame) {
  const Outcome outcome = dump("(12.250001) can1 291#10270000F0D8FFFF\n(13.0) can1 7FF#\n", {"--json"});
  std::istringstream lines(outcome.said);
  std::string first, second, none;
  ASSERT_TRUE(std::getline(lines, first) && std::getline(lines, second));
  EXPECT_FALSE(std::getline(lines, none));
  const auto json = nlohmann::json::parse(first);
  EXPECT_EQ(json["stamp"], 12.250001);
  EXPECT_EQ(json["bus"], "can1");
  EXPECT_EQ(json["id"], 0x291);
  EXPECT_EQ(json["data"], "10270000F0D8FFFF");
  EXPECT_EQ(json["name"], "PAN_Tpdo2");
  EXPECT_EQ(json["function"], "TPDO2");
  EXPECT_EQ(json["node"], 0x11);
  EXPECT_EQ(json["declared"], true);
  EXPECT_EQ(json["signals"]["Velocity"]["unit"], "deg/s");
  EXPECT_EQ(json["signals"]["Velocity"]["value"], -10);
  EXPECT_EQ(nlohmann::json::parse(second)["length"], 0);
}

TEST_F(CanDump, SaysWhatAValueMeansWhereItHasAName) {
  const std::string boot = "(1.0) can0 711#00\n", unnamed = "(1.0) can0 000#0111\n";
  EXPECT_THAT(dump(boot).said, HasSubstr("  State 0 (Boot-up)\n"));
  EXPECT_THAT(dump(unnamed).said, HasSubstr("  Command 1 (Start)  Node 17\n"));
  const auto json = nlohmann::json::parse(dump(unnamed, {"--json"}).said);
  EXPECT_EQ(json["signals"]["Command"]["meaning"], "Start");
  EXPECT_FALSE(json["signals"]["Node"].contains("meaning"));
}

TEST_F(CanDump, RefusesALogWithoutAFrame) {
  for (const char* log : {"", "\n\n"})
    EXPECT_TRUE(says(dump(log), {"a.log: holds no frame, expected a log that candump -l wrote"}));
}

TEST_F(CanDump, ReadsWhatItWroteInCandumpsForm) {
  EXPECT_TRUE(rc::check("the same lines come out as went in", [&] {
    std::string log;
    for (int lines = *rc::gen::inRange(1, 20); lines > 0; --lines) {
      const auto bits11 = *rc::gen::inRange(0, 0x800);
      const auto bits29 = *rc::gen::inRange(0x800, 0x20000000);
      std::string data;
      const int length = *rc::gen::inRange(0, 9);
      for (int i = 0; i < length; ++i) data += fmt::format("{:02X}", *rc::gen::inRange(0, 256));
      const std::string what = *rc::gen::element(
          fmt::format("{:03X}#{}", bits11, data), fmt::format("{:08X}#{}", bits29, data),
          fmt::format("{:03X}#R{}", bits11, length), fmt::format("{:08X}#R{}", bits29, length),
          fmt::format("{:08X}#{}", 0x20000000 | bits29, data));
      log += fmt::format("({:010}.{:06}) can{} {}\n", *rc::gen::inRange(0, 2'000'000'000),
                         *rc::gen::inRange(0, 1'000'000), *rc::gen::inRange(0, 3), what);
    }
    const Outcome outcome = dump(log, {"--candump"});
    RC_ASSERT(outcome.code == kSuccess);
    RC_ASSERT(outcome.said == log);
  }));
}

TEST_F(CanDump, EndsAfterSoManyFrames) {
  const Outcome outcome = dump("(1.0) can0 001#\n(1.0) can0 002#\nand then nonsense\n", {"--count", "2"});
  EXPECT_EQ(outcome.code, kSuccess) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("2 frames"));
}

TEST_F(CanDump, SaysWhichLineIsNoFrame) {
  for (const char* bad :
       {"hello", "(1.0) can0", "1.0 can0 123#11", "(1.0) can0 123", "(1.0) can0 12#11", "(1.0) can0 800#",
        "(1.0) can0 123#1", "(1.0) can0 123#112233445566778899", "(1.0) can0 123#GG", "(1.0) can0 123##011",
        "(1.0) can0 123#R9", "(x) can0 123#", "(-1.0) can0 123#", "(1.0) can0 40000000#",
        "(1.0) can0 123#11 maybe", "(1.0000000001) can0 123#"})
    EXPECT_TRUE(
        says(dump(std::string("\n\n") + bad + "\n"), {"a.log:3: ", "no classic CAN frame", "candump -l"}))
        << bad;
}

TEST_F(CanDump, PassesOverLinesThatAreNoFramesAndSaysSo) {
  const std::string good = "(1.0) can0 123#11\n";
  const Outcome outcome = dump(good + "hello\n" + good + "(1.0) can0 12");
  EXPECT_EQ(outcome.code, kNotReached);
  EXPECT_EQ(std::count(outcome.said.begin(), outcome.said.end(), '\n'), 2);
  EXPECT_THAT(outcome.error, AllOf(HasSubstr("a.log:2: 'hello' is no classic CAN frame"),
                                   HasSubstr("a.log:4: '(1.0) can0 12' is no classic CAN frame"),
                                   HasSubstr("passed over: 2\n"), HasSubstr("2 frames: ")));
}

TEST_F(CanDump, TellsOfTheFirstTenOfManyLinesThatAreNoFrames) {
  std::string log = "(1.0) can0 123#11\n";
  for (int i = 0; i < 1000; ++i) log += "nonsense\n";
  const Outcome outcome = dump(log);
  EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 12);
  EXPECT_THAT(outcome.error, HasSubstr("passed over: 1000\n"));
}

TEST_F(CanDump, WritesCodesAsTheStandardsDoAndNamesEmergencies) {
  EXPECT_THAT(dump("(1.0) can0 091#3081110000000000\n").said,
              HasSubstr("  Code 0x8130 (life guard or heartbeat error)  ErrorRegister 0x11  Vendor 0x00\n"));
  EXPECT_THAT(dump("(1.0) can0 092#0000000000000000\n").said,
              HasSubstr("  Code 0x0000 (error reset or no error)"));
  EXPECT_THAT(dump("(1.0) can0 191#371608\n").said, HasSubstr("  Statusword 0x1637  Mode 8\n"));
  EXPECT_THAT(dump("(1.0) can0 611#2316100100000000\n").said,
              HasSubstr("  Command 0x23  Index 0x1016  Subindex 0x01  Data 0x00\n"));
  const auto json = nlohmann::json::parse(dump("(1.0) can0 091#3081110000000000\n", {"--json"}).said);
  EXPECT_EQ(json["signals"]["Code"]["value"], 0x8130);
  EXPECT_EQ(json["signals"]["Code"]["meaning"], "life guard or heartbeat error");
}

TEST_F(CanDump, SaysWhatItNeeds) {
  EXPECT_TRUE(says(run_headway({"can", "dump"}),
                   {"can dump", "--bus", "--log", "socketcan:can0", "slcan:/dev/ttyACM0"}));
  EXPECT_TRUE(says(run_headway({"can", "dump", "--bus", "slcan:x", "--log", "y"}), {"either --bus"}));
  EXPECT_TRUE(says(run_headway({"can", "dump", "--bus", "can0"}),
                   {"is 'can0', expected one like", "socketcan:can0"}));
  EXPECT_TRUE(says(run_headway({"can", "dump", "--bus", "slcan:"}), {"is 'slcan:', expected one like"}));
  EXPECT_TRUE(
      says(run_headway({"can", "dump", "--bus", "socketcan:"}), {"is 'socketcan:', expected one like"}));
  EXPECT_TRUE(says(run_headway({"can", "dump", "--log", (folder_ / "absent").string()}),
                   {"absent", "cannot be read (No such file or directory)"}));
  EXPECT_TRUE(says(run_headway({"can", "dump", "--log", folder_.path().string()}),
                   {"cannot be read (Is a directory), expected a log"}));
  EXPECT_TRUE(says(dump("", {"--seconds", "1"}), {"--seconds is for a bus"}));
}

TEST_F(CanDump, ShowsALiveBus) {
  Pty pty;
  std::jthread adapter([&] {
    const Deadline deadline(std::chrono::seconds(20));
    std::string heard;
    while (heard.find("O\r") == std::string::npos && !deadline.passed()) heard += pty.read(1, deadline);
    pty.write("t711105\rT00000001011\rt29181027000000000000\rt7110\r");
  });
  const Outcome outcome =
      run_headway({"can", "dump", "--bus", "slcan:" + pty.path(), "--count", "2", "--seconds", "20"});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  EXPECT_THAT(outcome.said,
              AllOf(HasSubstr("711  [1]  05"), HasSubstr("Position 10 deg"), Not(HasSubstr("[0]"))));
  EXPECT_THAT(outcome.error, AllOf(HasSubstr("2 received"), HasSubstr("1 unusable"), HasSubstr("2 frames")));
}

TEST_F(CanDump, EndsWithItsCountsOnCtrlC) {
  Pty pty;
  std::jthread adapter([&] {
    const Deadline deadline(std::chrono::seconds(20));
    std::string heard;
    while (heard.find("O\r") == std::string::npos && !deadline.passed()) heard += pty.read(1, deadline);
    pty.write("t711105\r");
    EXPECT_TRUE(pty.wait_until_taken(deadline));
    kill(getpid(), SIGINT);
  });
  const Outcome outcome = run_headway({"can", "dump", "--bus", "slcan:" + pty.path(), "--seconds", "20"});
  EXPECT_EQ(outcome.code, kSuccess);
  EXPECT_THAT(outcome.error, AllOf(HasSubstr("1 received"), HasSubstr("1 frames: 0 unknown")));
}

TEST_F(CanDump, SaysThatABusIsGone) {
  Pty pty;
  std::jthread adapter([&] {
    const Deadline deadline(std::chrono::seconds(20));
    pty.read(8, deadline);
    pty.unplug();
  });
  const Outcome outcome = run_headway({"can", "dump", "--bus", "slcan:" + pty.path(), "--seconds", "0.3"});
  EXPECT_EQ(outcome.code, kNotReached);
  EXPECT_THAT(outcome.error, AllOf(HasSubstr(": gone\n"), HasSubstr("gone 1 times")));
}

TEST(CanopenPlace, IsThatOfThePredefinedConnectionSet) {
  const auto is = [](std::uint32_t id, std::string_view function, int node) {
    const CanopenPlace place = canopen_place(id);
    return place.function == function && place.node == node;
  };
  EXPECT_TRUE(is(0x000, "NMT", 0) && is(0x080, "SYNC", 0) && is(0x100, "TIME", 0));
  EXPECT_TRUE(is(0x081, "EMCY", 1) && is(0x0FF, "EMCY", 127));
  EXPECT_TRUE(is(0x181, "TPDO1", 1) && is(0x201, "RPDO1", 1) && is(0x281, "TPDO2", 1) &&
              is(0x301, "RPDO2", 1));
  EXPECT_TRUE(is(0x3FF, "TPDO3", 127) && is(0x47F, "RPDO3", 127) && is(0x4FF, "TPDO4", 127) &&
              is(0x57F, "RPDO4", 127));
  EXPECT_TRUE(is(0x591, "SDO answer", 0x11) && is(0x611, "SDO request", 0x11) &&
              is(0x711, "heartbeat", 0x11));
  for (const std::uint32_t none :
       {0x001u, 0x07Fu, 0x101u, 0x120u, 0x17Fu, 0x180u, 0x200u, 0x580u, 0x681u, 0x700u, 0x7E5u})
    EXPECT_TRUE(is(none, "", 0)) << none;
}

TEST(CanopenPlace, AgreesWithTheNamesInTheContract) {
  for (const bus::MessageInfo& m : bus::messages()) {
    const std::string_view function = canopen_place(m.id).function;
    for (const std::string_view known :
         {"Tpdo1", "Tpdo2", "Rpdo1", "Emcy", "SdoAnswer", "SdoRequest", "Heartbeat"})
      if (m.name.ends_with(known)) {
        EXPECT_TRUE(std::equal(function.begin(), function.begin() + 3, known.begin(), known.begin() + 3,
                               [](char a, char b) { return std::tolower(a) == std::tolower(b); }))
            << m.name << " is " << function;
      }
  }
}

}  // namespace
}  // namespace headway::app
