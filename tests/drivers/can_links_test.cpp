// What the kernel says of its CAN interfaces, laid out here by hand as rtnetlink(7) has it.
#include "drivers/can_links.h"

#include <cstring>
#include <string_view>

#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

using Bytes = std::vector<std::byte>;

template <class Value>
Bytes bytes_of(const Value& value) {
  Bytes bytes(sizeof value);
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}
Bytes bytes_of(const char* text) {
  Bytes bytes(std::strlen(text) + 1);
  std::memcpy(bytes.data(), text, bytes.size());
  return bytes;
}
Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}
Bytes padded(Bytes bytes) {
  bytes.resize((bytes.size() + 3) / 4 * 4);
  return bytes;
}
Bytes attribute(int type, const Bytes& body) {
  return padded(
      bytes_of(rtattr{static_cast<unsigned short>(4 + body.size()), static_cast<unsigned short>(type)}) +
      body);
}
Bytes message(unsigned short type, const Bytes& body) {
  nlmsghdr header{};
  header.nlmsg_len = static_cast<std::uint32_t>(sizeof header + body.size());
  header.nlmsg_type = type;
  return padded(bytes_of(header) + body);
}
Bytes link(unsigned short type, unsigned flags, const Bytes& attributes) {
  ifinfomsg info{};
  info.ifi_type = type;
  info.ifi_flags = flags;
  return message(RTM_NEWLINK, bytes_of(info) + attributes);
}

Bytes adapter(std::uint32_t state) {
  can_bittiming timing{};
  timing.bitrate = 500'000;
  timing.sample_point = 875;
  const Bytes data = attribute(IFLA_CAN_STATE, bytes_of(state)) +
                     attribute(IFLA_CAN_BITTIMING, bytes_of(timing)) +
                     attribute(IFLA_CAN_RESTART_MS, bytes_of(std::uint32_t{100}));
  return link(ARPHRD_CAN, IFF_UP,
              attribute(IFLA_IFNAME, bytes_of("can0")) +
                  attribute(IFLA_LINKINFO | NLA_F_NESTED,
                            attribute(IFLA_INFO_KIND, bytes_of("can")) + attribute(IFLA_INFO_DATA, data)));
}
Bytes virtual_bus() {
  return link(ARPHRD_CAN, 0,
              attribute(IFLA_IFNAME, bytes_of("vcan0")) +
                  attribute(IFLA_LINKINFO, attribute(IFLA_INFO_KIND, bytes_of("vcan"))));
}
Bytes answer() {
  return link(ARPHRD_ETHER, IFF_UP, attribute(IFLA_IFNAME, bytes_of("eth0"))) +
         adapter(CAN_STATE_ERROR_PASSIVE) + virtual_bus() + message(NLMSG_DONE, bytes_of(0));
}

TEST(CanLinks, AreTheCanInterfacesWithBitRateAndState) {
  const std::vector<CanLink> links = can_links_in(answer());
  ASSERT_EQ(links.size(), 2u);
  EXPECT_EQ(links[0].name, "can0");
  EXPECT_EQ(links[0].kind, "can");
  EXPECT_TRUE(links[0].is_up);
  EXPECT_EQ(links[0].controller, hal::CanBusState::kErrorPassive);
  EXPECT_EQ(links[0].bitrate, 500'000u);
  EXPECT_DOUBLE_EQ(links[0].sample_point, 0.875);
  EXPECT_EQ(links[0].restart, std::chrono::milliseconds(100));
  EXPECT_EQ(links[1].name, "vcan0");
  EXPECT_FALSE(links[1].is_up);
  EXPECT_FALSE(links[1].controller);
  EXPECT_EQ(links[1].bitrate, 0u);
}

TEST(CanLinks, CallAStoppedControllerOffTheBus) {
  for (const std::uint32_t state : {CAN_STATE_BUS_OFF, CAN_STATE_STOPPED, CAN_STATE_SLEEPING})
    EXPECT_EQ(can_links_in(adapter(state)).at(0).controller, hal::CanBusState::kBusOff) << state;
}

RC_GTEST_PROP(CanLinks, ReadNothingBeyondAnAnswerThatIsCutOrSpoilt, ()) {
  const Bytes whole = answer();
  // On the heap and as long as it is: a checker of memory sees a read beyond it.
  Bytes some(whole.begin(), whole.begin() + *rc::gen::inRange<long>(0, static_cast<long>(whole.size()) + 1));
  const auto spoilt = *rc::gen::container<std::vector<std::pair<std::size_t, std::uint8_t>>>(
      rc::gen::pair(rc::gen::inRange<std::size_t>(0, whole.size()), rc::gen::arbitrary<std::uint8_t>()));
  for (const auto& [at, value] : spoilt)
    if (at < some.size()) some[at] = std::byte{value};
  some.shrink_to_fit();
  RC_ASSERT(can_links_in(some).size() <= 5u);
}

TEST(CanLinks, CanBeAskedOfThisKernel) { EXPECT_NO_THROW(list_can_links()); }

}  // namespace
}  // namespace headway::drivers
