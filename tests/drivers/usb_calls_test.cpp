// libusb itself, as far as a machine without adapters allows; tests/hil has the rest.
#include "drivers/usb_calls.h"

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/gs_usb_bus.h"
#include "drivers/wake_up.h"
#include "hal/clock.h"
#include "hal/error.h"

namespace headway::drivers {
namespace {

class Libusb : public ::testing::Test {
 protected:
  void SetUp() override {
    const int error = libusb().init(&context);
    if (error < 0) GTEST_SKIP() << "libusb does not start here: " << libusb().error_name(error);
  }
  void TearDown() override {
    if (context != nullptr) libusb().exit(context);
  }
  Duration wait(Duration longest) {
    const Time begin = clock.now();
    EXPECT_EQ(libusb().handle_events(context, bell.descriptor(), longest), 0);
    return clock.now() - begin;
  }

  libusb_context* context = nullptr;
  WakeUp bell;
  hal::MonotonicClock clock;
};

TEST_F(Libusb, WaitsUntilTheTimeIsOver) {
  // USB may be busy with what is plugged into this machine, so that one wait in a hundred counts.
  Duration longest{};
  for (int i = 0; i < 100; ++i) longest = std::max(longest, wait(std::chrono::milliseconds(2)));
  EXPECT_GE(longest, std::chrono::milliseconds(2));
  wait(Duration(-1));
}

TEST_F(Libusb, ABellEndsTheWaitingUntilItIsHeard) {
  bell.ring();
  bell.ring();
  EXPECT_LT(wait(std::chrono::seconds(20)), std::chrono::seconds(10));
  EXPECT_LT(wait(std::chrono::seconds(20)), std::chrono::seconds(10)) << "nobody heard it";
  bell.hear();
  bell.hear();
  wait(std::chrono::milliseconds(1));
}

TEST(GsUsbBus, SaysThatAnAdapterIsNotThere) {
  hal::MonotonicClock clock;
  try {
    GsUsbBus bus({.serial = "no such adapter"}, clock);
    FAIL() << "expected an error";
  } catch (const Error& error) {
    EXPECT_THAT(std::string(error.what()), ::testing::HasSubstr("'no such adapter'"));
  }
}

}  // namespace
}  // namespace headway::drivers
