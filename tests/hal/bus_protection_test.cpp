#include "hal/bus_protection.h"

#include <string_view>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/bus_codec.h"

namespace headway::hal::bus {
namespace {

constexpr std::uint16_t kId = 0x123;

CanFrame blank() { return {.id = kId, .dlc = 8}; }

CanFrame any_frame() {
  CanFrame frame = blank();
  for (auto& byte : frame.data) byte = *rc::gen::arbitrary<std::uint8_t>();
  return frame;
}

TEST(Crc8, GivesTheCatalogueValue) {
  constexpr std::array<std::uint8_t, 9> kDigits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  static_assert(crc8(kDigits) == 0x37);
}

// The worked example of AUTOSAR's E2E protocol specification, profile 11, variant A (both bytes of the data
// id).
TEST(Protector, GivesTheValuesOfTheSpecification) {
  Protector protector(kId);
  CanFrame frame = blank();
  protector.protect(frame);
  EXPECT_EQ(frame.data, (std::array<std::uint8_t, 8>{0xCC, 0, 0, 0, 0, 0, 0, 0}));
  protector.protect(frame);
  EXPECT_EQ(frame.data, (std::array<std::uint8_t, 8>{0x91, 1, 0, 0, 0, 0, 0, 0}));
}

TEST(Protector, CountsFromZeroToFourteen) {
  Protector protector(kId);
  for (int i = 0; i < 40; ++i) {
    CanFrame frame = blank();
    protector.protect(frame);
    EXPECT_EQ(frame.data[1], i % 15);
  }
}

RC_GTEST_PROP(Protector, ChangesNothingButCrcAndCounter, ()) {
  const CanFrame before = any_frame();
  CanFrame after = before;
  Protector(kId).protect(after);
  RC_ASSERT((after.data[1] & 0xF0) == (before.data[1] & 0xF0));
  RC_ASSERT(std::equal(before.data.begin() + 2, before.data.end(), after.data.begin() + 2));
}

RC_GTEST_PROP(Checker, TakesEveryFrameOfAnUnbrokenStream, ()) {
  Protector protector(kId);
  ProtectionChecker checker(kId);
  for (int i = 0; i < 50; ++i) {
    CanFrame frame = any_frame();
    protector.protect(frame);
    RC_ASSERT(checker.check(frame) == Check::kOk);
  }
}

// Any burst of up to eight bits is found by a CRC of eight bits; single and double errors within the frame
// too.
RC_GTEST_PROP(Checker, FindsEveryBurstOfUpToEightBits, ()) {
  Protector protector(kId);
  ProtectionChecker checker(kId);
  CanFrame frame = any_frame();
  protector.protect(frame);
  const auto pattern = *rc::gen::inRange<unsigned>(1, 256);
  // Within the CRC's own byte, or within the bytes it runs over, which it does not follow directly.
  const auto shift = *rc::gen::oneOf(rc::gen::just(0u), rc::gen::inRange<unsigned>(8, 57));
  for (unsigned bit = 0; bit < 8; ++bit) {
    // Most significant bit first, the order in which the CRC runs.
    const unsigned at = shift + bit;
    if ((pattern >> bit) & 1)
      frame.data[at / 8] = static_cast<std::uint8_t>(frame.data[at / 8] ^ (0x80 >> (at % 8)));
  }
  RC_ASSERT(checker.check(frame) == Check::kWrongCrc);
  RC_ASSERT(checker.counts().wrong_crc == 1u);
}

RC_GTEST_PROP(Checker, RefusesAFrameOfAnotherMessage, ()) {
  const auto other = static_cast<std::uint16_t>(*rc::gen::inRange(0, 0x800));
  RC_PRE(other != kId);
  CanFrame frame = any_frame();
  Protector(other).protect(frame);
  // Two ids of 11 bits can share a CRC; those of our messages do not (below).
  const bool same = frame_crc(frame, other) == frame_crc(frame, kId);
  ProtectionChecker checker(kId);
  RC_ASSERT((checker.check(frame) == Check::kWrongCrc) == !same);
}

TEST(Checker, TellsOurMessagesApart) {
  for (const MessageInfo& a : messages()) {
    for (const MessageInfo& b : messages()) {
      if (a.data_id == 0 || b.data_id == 0 || a.data_id == b.data_id) continue;
      EXPECT_NE(frame_crc(blank(), a.data_id), frame_crc(blank(), b.data_id)) << a.name << ' ' << b.name;
    }
  }
}

TEST(Checker, RefusesARepeatedCounterAndTakesTheNext) {
  Protector protector(kId);
  ProtectionChecker checker(kId);
  CanFrame first = blank(), second = blank();
  protector.protect(first);
  protector.protect(second);
  EXPECT_EQ(checker.check(first), Check::kOk);
  EXPECT_EQ(checker.check(first), Check::kRepeated);
  EXPECT_EQ(checker.check(first), Check::kRepeated);
  EXPECT_EQ(checker.check(second), Check::kOk);
  EXPECT_EQ(checker.counts().repeated, 2u);
}

TEST(Checker, RefusesTheCounterThatNeverTravels) {
  CanFrame frame = blank();
  frame.data[1] = 15;
  frame.data[0] = frame_crc(frame, kId);
  EXPECT_EQ(ProtectionChecker(kId).check(frame), Check::kWrongCrc);
}

RC_GTEST_PROP(Checker, CountsLossesAndResynchronisesAfterMany, ()) {
  const int lost = *rc::gen::inRange(0, 14);
  Protector protector(kId);
  ProtectionChecker checker(kId, 5);
  CanFrame frame = blank();
  protector.protect(frame);
  RC_ASSERT(checker.check(frame) == Check::kOk);
  for (int i = 0; i < lost; ++i) protector.protect(frame);
  protector.protect(frame);
  const Check verdict = checker.check(frame);
  if (lost == 0) RC_ASSERT(verdict == Check::kOk);
  if (lost > 0 && lost < 5) RC_ASSERT(verdict == Check::kOkSomeLost);
  if (lost >= 5) RC_ASSERT(verdict == Check::kWrongSequence);
  if (lost < 5) RC_ASSERT(checker.counts().lost == static_cast<std::uint32_t>(lost));
  protector.protect(frame);
  RC_ASSERT(checker.check(frame) == Check::kOk);
}

}  // namespace
}  // namespace headway::hal::bus
