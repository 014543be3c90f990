// That the codec is what the DBC says is checked against python3-canmatrix (tests/tree/bus_codec_test.py);
// here is what the C++ side adds to that.
#include "hal/bus_codec.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::hal::bus {
namespace {

// Checked while compiling: the bits of the table in docs/bus.md, counted by hand.
constexpr auto kStep = StepCommand{.crc = 0xA5,
                                   .counter = 3,
                                   .foot = StepCommand::Foot::kRight,
                                   .seq = 1,
                                   .session = 1,
                                   .dx = 0.001,
                                   .dy = -0.001,
                                   .dtheta = 0.002,
                                   .duration = 0.8,
                                   .dz = -0.008}
                           .pack();
static_assert(kStep.has_value());
static_assert(kStep->id == 0x120 && kStep->dlc == 8);
static_assert(kStep->data == std::array<std::uint8_t, 8>{0xA5, 0x13, 0x41, 0x04, 0xF0, 0x7F, 0x00, 0xFC});
static_assert(StepCommand::unpack(*kStep)->dy == -0.001);
static_assert(WalkStatus::kTimeout == std::chrono::milliseconds(100));
static_assert(WalkStatus{.session = 15, .seq_rejected = 63}.pack()->data[7] == 0xFF);

TEST(Codec, RefusesWhatIsNoNumberOrFarOutside) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double dx : {kNan, kInf, -kInf, 1e300, -1e300, 0.5121, -0.5131}) {
    EXPECT_FALSE((StepCommand{.dx = dx}.pack())) << dx;
  }
  EXPECT_TRUE((StepCommand{.dx = 0.5114}.pack()));
}

TEST(Codec, RefusesAnotherIdOrLength) {
  CanFrame frame = *WalkStatus{}.pack();
  EXPECT_TRUE(WalkStatus::unpack(frame));
  frame.dlc = 7;
  EXPECT_FALSE(WalkStatus::unpack(frame));
  frame.dlc = 8;
  frame.id = ChestXY::kId;
  EXPECT_FALSE(WalkStatus::unpack(frame));
}

TEST(Codec, RefusesUnlistedNames) {
  CanFrame frame = *Heartbeat{.state = Heartbeat::State::kOperational}.pack(0x711);
  EXPECT_TRUE(Heartbeat::unpack(frame));
  frame.data[0] = 6;
  EXPECT_FALSE(Heartbeat::unpack(frame));
  EXPECT_FALSE(Heartbeat{.state = static_cast<Heartbeat::State>(6)}.pack(0x711));
}

TEST(Codec, RefusesANodeThatIsNotOurs) {
  EXPECT_TRUE(DriveStatus{}.pack(0x191));
  EXPECT_FALSE(DriveStatus{}.pack(0x193));
}

RC_GTEST_PROP(Codec, GivesBackWhateverItUnpacks, ()) {
  const auto& all = messages();
  const MessageInfo& info = all[*rc::gen::inRange<std::size_t>(0, all.size())];
  CanFrame frame{.id = info.id, .dlc = info.dlc};
  for (unsigned i = 0; i < info.dlc; ++i) frame.data[i] = *rc::gen::arbitrary<std::uint8_t>();
  std::array<double, 16> values{};
  if (!unpack_values(frame, values)) return;
  const auto back = pack_values(info.id, std::span(values).first(info.signals.size()));
  RC_ASSERT(back.has_value());
  // Bits that no signal uses are sent as zero: packing what was unpacked settles at once.
  std::array<double, 16> again{};
  RC_ASSERT(unpack_values(*back, again));
  RC_ASSERT(again == values);
}

RC_GTEST_PROP(Codec, RoundsToTheNearestUnit, ()) {
  const double yaw = *rc::gen::inRange(-3276000, 3276000) * 1e-6;
  const auto frame = ChestZRot{.yaw = yaw}.pack();
  RC_ASSERT(frame.has_value());
  RC_ASSERT(std::abs(ChestZRot::unpack(*frame)->yaw - yaw) <= 0.5e-4 + 1e-12);
}

}  // namespace
}  // namespace headway::hal::bus
