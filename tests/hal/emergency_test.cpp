#include "hal/emergency.h"

#include <set>

#include <gtest/gtest.h>

namespace headway::hal {
namespace {

TEST(Emergency, IsNamedByTheNarrowestClassThatTheStandardsKnow) {
  EXPECT_EQ(name_of_emergency(0x0000), "error reset or no error");
  EXPECT_EQ(name_of_emergency(0x8130), "life guard or heartbeat error");
  EXPECT_EQ(name_of_emergency(0x8131), "communication");
  EXPECT_EQ(name_of_emergency(0x8611), "following error");
  EXPECT_EQ(name_of_emergency(0x8700), "monitoring");
  EXPECT_EQ(name_of_emergency(0x2310), "current, output side");
  EXPECT_EQ(name_of_emergency(0x2400), "current");
  EXPECT_EQ(name_of_emergency(0x4210), "device temperature");
  EXPECT_EQ(name_of_emergency(0xFF01), "device specific");
}

/// A narrow class that stands behind a wide one would never be found.
TEST(Emergency, LeavesNoNameUnused) {
  std::set<std::string_view> names;
  for (std::uint32_t code = 0; code <= 0xFFFF; ++code)
    names.insert(name_of_emergency(static_cast<std::uint16_t>(code)));
  EXPECT_EQ(names.size(), 37u) << "36, and none for what is reserved";
  EXPECT_EQ(name_of_emergency(0xA000), "");
}

}  // namespace
}  // namespace headway::hal
