// Oracle: the kernel's own headers for error frames, linux/can.h and linux/can/error.h.
#include "drivers/gs_usb_protocol.h"

#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers::gs_usb {
namespace {

using hal::CanBusState;

HostFrame error_frame(std::uint32_t classes, std::uint8_t controller, std::uint8_t transmit,
                      std::uint8_t receive) {
  HostFrame f;
  f.can_id = CAN_ERR_FLAG | classes;
  f.dlc = CAN_ERR_DLC;
  f.data = {0, controller, 0, 0, 0, 0, transmit, receive};
  return f;
}

RC_GTEST_PROP(HostFrame, ComesThroughTheWireAsItWas, ()) {
  HostFrame f;
  f.echo_id = *rc::gen::arbitrary<std::uint32_t>();
  f.can_id = *rc::gen::arbitrary<std::uint32_t>();
  f.dlc = *rc::gen::arbitrary<std::uint8_t>();
  f.channel = *rc::gen::arbitrary<std::uint8_t>();
  f.flags = *rc::gen::arbitrary<std::uint8_t>();
  f.data = *rc::gen::arbitrary<std::array<std::uint8_t, 8>>();
  const auto bytes = f.pack();
  RC_ASSERT(HostFrame::unpack(bytes) == f);
}

TEST(HostFrame, LiesOnTheWireLittleEndianAndWithItsTimeBehind) {
  const std::vector<std::uint8_t> bytes{0xFF, 0xFF, 0xFF, 0xFF, 0x23, 0x01, 0, 0, 3,    2,    1,    0,
                                        0xA,  0xB,  0xC,  0,    0,    0,    0, 0, 0x78, 0x56, 0x34, 0x12};
  const auto f = HostFrame::unpack(bytes);
  ASSERT_TRUE(f);
  EXPECT_EQ(f->echo_id, HostFrame::kReceived);
  EXPECT_EQ(f->can_id, 0x123u);
  EXPECT_EQ(f->dlc, 3);
  EXPECT_EQ(f->channel, 2);
  EXPECT_TRUE(f->tells_of_losses());
  EXPECT_EQ(f->data[2], 0xC);
  EXPECT_EQ(f->timestamp_us, 0x12345678u);
  EXPECT_FALSE(HostFrame::unpack(std::span(bytes).first(20))->timestamp_us);
}

RC_GTEST_PROP(HostFrame, IsNoneOfAnyOtherLength, (const std::vector<std::uint8_t>& bytes)) {
  RC_ASSERT(HostFrame::unpack(bytes).has_value() == (bytes.size() == 20 || bytes.size() == 24));
}

TEST(HostFrame, HasTheKernelsFlags) {
  EXPECT_EQ(HostFrame::kExtended, CAN_EFF_FLAG);
  EXPECT_EQ(HostFrame::kRemote, CAN_RTR_FLAG);
  EXPECT_EQ(HostFrame::kError, CAN_ERR_FLAG);
}

TEST(ErrorFrame, SaysWhatTheKernelsHeaderSays) {
  struct Case {
    std::uint32_t classes;
    std::uint8_t controller;
    CanBusState expected;
  };
  const ControllerState before{CanBusState::kErrorWarning, 1, 2};
  for (const Case& c :
       {Case{CAN_ERR_CRTL, CAN_ERR_CRTL_RX_WARNING, CanBusState::kErrorWarning},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING, CanBusState::kErrorWarning},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_RX_PASSIVE, CanBusState::kErrorPassive},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE, CanBusState::kErrorPassive},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE | CAN_ERR_CRTL_RX_WARNING, CanBusState::kErrorPassive},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE, CanBusState::kErrorActive},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_UNSPEC, CanBusState::kErrorActive},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW, CanBusState::kErrorWarning},
        {CAN_ERR_BUSOFF, 0, CanBusState::kBusOff},
        {CAN_ERR_BUSOFF | CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE, CanBusState::kBusOff},
        {CAN_ERR_RESTARTED, 0, CanBusState::kErrorActive},
        {CAN_ERR_ACK, 0, CanBusState::kErrorWarning},
        {CAN_ERR_PROT | CAN_ERR_BUSERROR, 0, CanBusState::kErrorWarning}}) {
    EXPECT_EQ(error_frame(c.classes, c.controller, 0, 0).controller_state(before).state, c.expected)
        << std::hex << c.classes << ' ' << int{c.controller};
  }
}

TEST(ErrorFrame, TellsTheCountersWhereItHasThem) {
  const ControllerState before{CanBusState::kErrorActive, 1, 2};
  const auto with = error_frame(CAN_ERR_CNT, 0, 130, 96).controller_state(before);
  EXPECT_EQ(with.transmit_errors, 130);
  EXPECT_EQ(with.receive_errors, 96);
  const auto without = error_frame(CAN_ERR_ACK, 0, 0, 0).controller_state(before);
  EXPECT_EQ(without, before);
}

TEST(ErrorFrame, TellsOfFramesThatTheControllerHadNoRoomFor) {
  EXPECT_TRUE(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW, 0, 0).tells_of_losses());
  EXPECT_FALSE(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_OVERFLOW, 0, 0).tells_of_losses());
  HostFrame data;
  data.data[1] = CAN_ERR_CRTL_RX_OVERFLOW;
  EXPECT_FALSE(data.tells_of_losses());
}

RC_GTEST_PROP(HostFrame, IsADataFrameOnlyWithoutAnyFlag, (std::uint32_t can_id, std::uint8_t dlc)) {
  HostFrame f;
  f.can_id = *rc::gen::element(can_id, can_id % 0x800);
  f.dlc = dlc;
  const auto frame = f.can_frame();
  RC_ASSERT(frame.has_value() == (f.can_id <= CAN_SFF_MASK));
  if (frame) RC_ASSERT(frame->id == f.can_id && frame->dlc <= 8);
}

TEST(ControllerState, WhatIsStoppedOrAsleepOrUnknownIsOffTheBus) {
  for (std::uint8_t state = 0; state < 8; ++state) {
    const std::array<std::uint8_t, 12> bytes{state, 0, 0, 0, 7, 1, 0, 0, 9, 0, 0, 0};
    const auto s = ControllerState::unpack(bytes);
    EXPECT_EQ(s.state, static_cast<CanBusState>(std::min<int>(state, 3)));
    EXPECT_EQ(s.receive_errors, 255) << "no more than the counter holds";
    EXPECT_EQ(s.transmit_errors, 9);
  }
}

}  // namespace
}  // namespace headway::drivers::gs_usb
