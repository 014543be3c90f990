#include "app/examine_can_links.h"

#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace headway::app {
namespace {

using testing::HasSubstr;

drivers::CanLink good() {
  return {.name = "can0",
          .kind = "can",
          .is_up = true,
          .controller = hal::CanBusState::kErrorActive,
          .bitrate = 500'000,
          .sample_point = 0.875,
          .restart = std::chrono::milliseconds(100)};
}

drivers::CanLink virtual_bus(bool is_up) {
  drivers::CanLink link;
  link.name = "vcan0";
  link.kind = "vcan";
  link.is_up = is_up;
  return link;
}

Finding finding_on(const std::function<void(drivers::CanLink&)>& spoil) {
  drivers::CanLink link = good();
  spoil(link);
  Diagnosis diagnosis;
  examine_can_links({link}, "can0", diagnosis);
  EXPECT_EQ(diagnosis.findings().size(), 1u);
  return diagnosis.findings().front();
}

TEST(ExamineCanLinks, SaysHowEachIsSet) {
  Diagnosis diagnosis;
  examine_can_links({good(), virtual_bus(false)}, "can0", diagnosis);
  EXPECT_EQ(diagnosis.worst(), Verdict::kOk) << "the other one may be as it likes";
  EXPECT_EQ(
      diagnosis.text(),
      "ok    can      can0: up, error active, 500000 bit/s, sample point 87.5 %, back 100 ms after it went "
      "off (can)\n"
      "ok    can      vcan0: down, no bit rate (vcan)\n");
}

TEST(ExamineCanLinks, SaysHowToSetUpTheRobots) {
  const Finding down = finding_on([](auto& link) { link.is_up = false; });
  EXPECT_EQ(down.verdict, Verdict::kFail);
  EXPECT_THAT(down.remedy,
              HasSubstr("ip link set can0 up type can bitrate 500000 sample-point 0.875 restart-ms 100"));
  EXPECT_EQ(finding_on([](auto& link) { link.bitrate = 250'000; }).verdict, Verdict::kFail);
  const Finding off = finding_on([](auto& link) { link.controller = hal::CanBusState::kBusOff; });
  EXPECT_EQ(off.verdict, Verdict::kFail);
  EXPECT_THAT(off.found, HasSubstr("off the bus"));
  EXPECT_EQ(finding_on([](auto& link) { link.sample_point = 0.75; }).verdict, Verdict::kWarn);
  const Finding stays = finding_on([](auto& link) { link.restart = Duration::zero(); });
  EXPECT_EQ(stays.verdict, Verdict::kWarn);
  EXPECT_THAT(stays.found, HasSubstr("stays off"));
}

TEST(ExamineCanLinks, AsksNoBitRateOfAVirtualBus) {
  Diagnosis diagnosis;
  examine_can_links({virtual_bus(true)}, "vcan0", diagnosis);
  EXPECT_EQ(diagnosis.worst(), Verdict::kOk) << diagnosis.text();
}

TEST(ExamineCanLinks, MissesTheRobots) {
  Diagnosis diagnosis;
  examine_can_links({good()}, "can1", diagnosis);
  EXPECT_THAT(diagnosis.text(), HasSubstr("fail  can      can1: there is no such interface"));
  Diagnosis without_can;
  examine_can_links({}, "can0", without_can, false);
  EXPECT_THAT(without_can.text(), HasSubstr("fail  can      can0: the kernel has no CAN"));
  EXPECT_THAT(without_can.text(), testing::Not(HasSubstr("plug")));
  Diagnosis none;
  examine_can_links({}, "", none);
  EXPECT_EQ(none.worst(), Verdict::kOk);
}

}  // namespace
}  // namespace headway::app
