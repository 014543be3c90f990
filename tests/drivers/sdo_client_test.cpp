#include "drivers/sdo_client.h"

#include <gtest/gtest.h>

#include "tests/drivers/scripted_bus.h"

namespace headway::drivers {
namespace {

namespace object = hal::cia402::object;
using hal::bus::SdoAnswer;
using hal::bus::SdoRequest;
using Status = SdoClient::Status;
using std::chrono::milliseconds;

class Sdo : public ::testing::Test {
 protected:
  SdoRequest asked() { return SdoRequest::unpack(bus.sent.back()).value(); }
  void answer(const SdoAnswer& a, std::uint32_t id = 0x591) { client.receive(a.pack(id).value()); }

  testing::ScriptedBus bus;
  CanopenMaster master{bus};
  SdoClient client{master, 0x11, {}};
  Time now = at_seconds(1);
};

TEST_F(Sdo, WritesEachSizeWithItsOwnCommandByte) {
  client.write(object::kTpdo1Type, 1);
  client.tick(now);
  EXPECT_EQ(asked(), (SdoRequest{.command = 0x2F, .index = 0x1800, .subindex = 2, .data = 1}));
  client.write(object::kQuickStopOption, 6);
  client.tick(now);
  EXPECT_EQ(asked(), (SdoRequest{.command = 0x2B, .index = 0x605A, .data = 6}));
  client.write(object::kPositionLimitLow, static_cast<std::uint32_t>(-45000));
  client.tick(now);
  EXPECT_EQ(asked(), (SdoRequest{.command = 0x23, .index = 0x607D, .subindex = 1, .data = 0xFFFF5038}));
}

TEST_F(Sdo, IgnoresAnswersToOtherQuestions) {
  client.read(object::kStatusword);
  client.tick(now);
  answer({.command = 0x4B, .index = 0x6040, .data = 7});  // another object
  answer({.command = 0x4B, .index = 0x6041, .subindex = 1, .data = 7});
  answer({.command = 0x60, .index = 0x6041});                      // to a write
  answer({.command = 0x43, .index = 0x6041, .data = 7});           // of another size
  answer({.command = 0x4B, .index = 0x6041, .data = 7}, 0x592);    // of another node
  answer({.command = 0x80, .index = 0x6040, .data = 0x06020000});  // refuses another object
  EXPECT_EQ(client.status(), Status::kBusy);
  answer({.command = 0x4B, .index = 0x6041, .data = 0xFFFF0237});
  EXPECT_EQ(client.status(), Status::kDone);
  EXPECT_EQ(client.value(), 0x0237u);
}

TEST_F(Sdo, TakesAnAnswerThatDoesNotTellItsSize) {
  client.read(object::kMode);
  client.tick(now);
  answer({.command = 0x42, .index = 0x6060, .data = 0xABCDEF01});
  EXPECT_EQ(client.value(), 0x01u);
}

TEST_F(Sdo, TellsWhyItWasRefused) {
  client.write(object::kProfileVelocity, 1);
  client.tick(now);
  answer({.command = 0x80, .index = 0x6081, .data = hal::cia402::sdo::kValueRange});
  EXPECT_EQ(client.status(), Status::kRefused);
  EXPECT_EQ(client.abort_code(), hal::cia402::sdo::kValueRange);
}

TEST_F(Sdo, GivesUpAfterThreeTries) {
  client.read(object::kStatusword);
  for (; client.status() == Status::kBusy && now < at_seconds(10); now += milliseconds(5)) client.tick(now);
  EXPECT_EQ(client.status(), Status::kTimedOut);
  EXPECT_EQ(bus.sent.size(), 3u);
  EXPECT_EQ(now - milliseconds(5) - at_seconds(1), milliseconds(1500));
}

TEST_F(Sdo, ATryThatFoundNoRoomOnTheBusIsNoTry) {
  client.read(object::kStatusword);
  bus.full = true;
  for (int i = 0; i < 1000; ++i) client.tick(now += milliseconds(5));
  bus.full = false;
  client.tick(now += milliseconds(5));
  EXPECT_EQ(client.status(), Status::kBusy);
  EXPECT_EQ(bus.sent.size(), 1u);
}

}  // namespace
}  // namespace headway::drivers
