#include "drivers/can_mailbox.h"

#include <array>
#include <deque>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

using hal::CanBusState;

RC_GTEST_PROP(CanMailbox, HoldsTenFramesInOrderAndRefusesMore, (const std::vector<std::uint8_t>& deeds)) {
  CanMailbox box;
  std::deque<std::uint32_t> waiting;  // a plain model of it
  std::uint64_t under_way = 0, taken = 0, refused = 0, sent = 0;
  std::uint32_t next = 0;
  for (const std::uint8_t deed : deeds) {
    if (deed % 2 == 0) {
      const bool accepted = box.send({.id = next % 0x800, .dlc = 0, .data = {}, .stamp = {}});
      RC_ASSERT(accepted == (under_way < 10));
      if (accepted) {
        ++under_way;
        waiting.push_back(next % 0x800);
      } else {
        ++refused;
      }
      ++next;
    } else if (deed % 4 == 1) {
      hal::CanFrame frame;
      const bool got = box.take(frame);
      RC_ASSERT(got == !waiting.empty());
      if (!got) continue;
      RC_ASSERT(frame.id == waiting.front());
      waiting.pop_front();
      ++taken;
    } else if (taken > 0) {
      box.settle(deed % 8 == 3);
      sent += deed % 8 == 3;
      --taken;
      --under_way;
    }
  }
  RC_ASSERT(box.stats().sent == sent);
  RC_ASSERT(box.stats().refused == refused);
}

TEST(CanMailbox, CountsEachTimeTheBusGoesOffOrAwayOnce) {
  CanMailbox box;
  for (int i = 0; i < 3; ++i) {
    box.set_state(CanBusState::kBusOff);
    box.set_state(CanBusState::kBusOff, 255, 7);
    box.set_state(CanBusState::kGone);
    box.set_state(CanBusState::kGone);
    box.set_state(CanBusState::kErrorActive);
  }
  EXPECT_EQ(box.stats().bus_off, 3u);
  EXPECT_EQ(box.stats().gone, 3u);
}

TEST(CanMailbox, CountsWhatNobodyTookInTime) {
  CanMailbox box;
  for (std::uint32_t i = 0; i < CanMailbox::kIncoming + 3; ++i)
    box.deliver({.id = i, .dlc = 0, .data = {}, .stamp = {}});
  EXPECT_EQ(box.stats().received, CanMailbox::kIncoming + 3);
  EXPECT_EQ(box.stats().lost, 3u);
  std::array<hal::CanFrame, CanMailbox::kIncoming + 3> frames;
  EXPECT_EQ(box.receive(frames), CanMailbox::kIncoming);
  EXPECT_EQ(frames[5].id, 5u) << "the oldest are kept, in order";
}

}  // namespace
}  // namespace headway::drivers
