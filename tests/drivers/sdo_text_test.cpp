// Reading texts from a node that serves them as CiA 301, 7.2.4.3 says, written here by hand.
#include "drivers/sdo_text.h"

#include <algorithm>
#include <deque>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

constexpr std::uint8_t kNode = 0x11;
constexpr std::uint16_t kName = 0x1008;

/// A node with one text.
struct Server final : hal::CanBus {
  std::string text;
  bool expedites = true;  ///< what fits into one answer
  int deaf_to = 0;        ///< so many requests
  int requests = 0, aborted = 0, given_up = 0;
  std::deque<hal::CanFrame> answers;

  bool send(const hal::CanFrame& request) noexcept override {
    EXPECT_EQ(request.id, 0x600u + kNode);
    EXPECT_EQ(request.dlc, 8);
    ++requests;
    if (deaf_to-- > 0) return true;
    const auto& in = request.data;
    if (in[0] == 0x80)
      ++given_up;
    else if (in[0] == 0x40)
      begin(in[1] | in[2] << 8, in[3]);
    else if (in[0] == (toggle_ ? 0x70 : 0x60))
      next();
    else
      abort();
    return true;
  }
  std::size_t receive(std::span<hal::CanFrame>) noexcept override { return 0; }
  hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }

 private:
  void answer(std::array<std::uint8_t, 8> data) {
    answers.push_back({.id = 0x580u + kNode, .dlc = 8, .data = data, .stamp = {}});
  }
  void abort(int index = kName) {
    ++aborted;
    answer(
        {0x80, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), 0, 0, 0, 0x02, 0x06});
  }
  void begin(int index, int subindex) {
    if (index != kName || subindex != 0) return abort(index);
    const auto size = static_cast<std::uint8_t>(text.size());
    std::array<std::uint8_t, 8> data{0x41, 0x08, 0x10, 0, size};
    at_ = 0;
    toggle_ = false;
    if (expedites && size >= 1 && size <= 4) {
      data[0] = static_cast<std::uint8_t>(0x43 | (4 - size) << 2);
      data[4] = 0;
      std::copy(text.begin(), text.end(), data.begin() + 4);
    }
    answer(data);
  }
  void next() {
    const std::size_t some = std::min<std::size_t>(7, text.size() - at_);
    const bool is_last = at_ + some == text.size();
    std::array<std::uint8_t, 8> data{
        static_cast<std::uint8_t>((toggle_ ? 0x10 : 0) | (7 - some) << 1 | (is_last ? 1 : 0))};
    std::copy_n(text.begin() + static_cast<std::ptrdiff_t>(at_), some, data.begin() + 1);
    at_ += some;
    toggle_ = !toggle_;
    answer(data);
  }
  std::size_t at_ = 0;
  bool toggle_ = false;
};

/// Until it is no longer busy, or ten seconds are over.
void read(SdoText& reader, Server& server, std::uint16_t index = kName) {
  reader.read(index);
  for (Time now = at_seconds(1); now < at_seconds(11) && reader.status() == SdoText::Status::kBusy;
       now += std::chrono::milliseconds(5)) {
    reader.tick(now);
    for (; !server.answers.empty(); server.answers.pop_front()) reader.receive(server.answers.front());
  }
}

RC_GTEST_PROP(SdoText, IsReadAsItIsWhateverItsLength, ()) {
  Server server;
  server.text = *rc::gen::container<std::string>(rc::gen::inRange<char>(' ', '~'));
  server.expedites = *rc::gen::arbitrary<bool>();
  SdoText reader(server, kNode);
  for (int i = 0; i < 2; ++i) {
    read(reader, server);
    RC_ASSERT(reader.status() == SdoText::Status::kDone);
    RC_ASSERT(std::string(reader.text()) == server.text.substr(0, SdoText::kMost));
  }
  RC_ASSERT(server.aborted == 0);
}

TEST(SdoText, LongerThanItsRoomIsCut) {
  Server server;
  server.text = std::string(200, 'x');
  SdoText reader(server, kNode);
  read(reader, server);
  EXPECT_EQ(reader.text(), std::string(SdoText::kMost, 'x'));
}

TEST(SdoText, IsRefusedWhereTheNodeHasNone) {
  Server server;
  SdoText reader(server, kNode);
  read(reader, server, 0x1009);
  EXPECT_EQ(reader.status(), SdoText::Status::kRefused);
}

TEST(SdoText, IsAskedForThreeTimes) {
  Server server;
  server.text = "motor";
  server.deaf_to = 2;
  SdoText reader(server, kNode);
  read(reader, server);
  EXPECT_EQ(reader.text(), "motor");
  server.deaf_to = 99;
  server.requests = 0;
  read(reader, server);
  EXPECT_EQ(reader.status(), SdoText::Status::kTimedOut);
  EXPECT_EQ(server.requests, 3);
}

TEST(SdoText, GivesUpATransferThatTheNodeLeavesHalfDone) {
  Server server;
  server.text = "a motor with a long name";
  SdoText reader(server, kNode);
  reader.read(kName);
  reader.tick(at_seconds(1));
  reader.receive(server.answers.front());
  server.deaf_to = 1;
  for (Time now = at_seconds(1); now < at_seconds(5); now += std::chrono::milliseconds(5)) reader.tick(now);
  EXPECT_EQ(reader.status(), SdoText::Status::kTimedOut);
  EXPECT_EQ(server.given_up, 1);
}

TEST(SdoText, LeavesAnAbortOfAnotherTransferAlone) {
  Server server;
  SdoText reader(server, kNode);
  reader.read(kName);
  reader.tick(at_seconds(1));
  reader.receive({.id = 0x580u + kNode, .dlc = 8, .data = {0x80, 0x17, 0x10, 0, 0, 0, 2, 6}, .stamp = {}});
  EXPECT_EQ(reader.status(), SdoText::Status::kBusy);
}

RC_GTEST_PROP(SdoText, WhateverComesIsNeverMoreThanItsRoom, ()) {
  Server server;
  SdoText reader(server, kNode);
  reader.read(kName);
  Time now = at_seconds(1);
  const auto answers = *rc::gen::container<std::vector<std::array<std::uint8_t, 8>>>(
      rc::gen::container<std::array<std::uint8_t, 8>>(rc::gen::arbitrary<std::uint8_t>()));
  for (const auto& data : answers) {
    reader.tick(now);
    reader.receive({.id = 0x580u + kNode, .dlc = 8, .data = data, .stamp = {}});
    now += std::chrono::milliseconds(5);
  }
  RC_ASSERT(reader.text().size() <= SdoText::kMost);
}

}  // namespace
}  // namespace headway::drivers
