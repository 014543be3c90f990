#include "app/interrupts.h"

#include <csignal>

#include <gtest/gtest.h>

namespace headway::app {
namespace {

TEST(Interrupts, TellThatSomebodyWantsTheProgramToEndAndLetItGoOn) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const Interrupts interrupts;  // with a terminal or without
    EXPECT_FALSE(interrupts.asked());
    std::raise(signal);
    EXPECT_TRUE(interrupts.asked()) << signal;
  }
}

TEST(Interrupts, TellAServiceOfAHangUpAsAWishToReadFilesAgain) {
  Interrupts interrupts(HangUp::kAsksToReload);
  EXPECT_FALSE(interrupts.asked_to_reload());
  for (int i = 0; i < 2; ++i) {
    std::raise(SIGHUP);
    EXPECT_TRUE(interrupts.asked_to_reload());
    EXPECT_FALSE(interrupts.asked_to_reload());
    EXPECT_FALSE(interrupts.asked());
  }
}

TEST(Interrupts, LetNoReaderThatLeftEndTheProgram) {
  const Interrupts interrupts;
  std::raise(SIGPIPE);
  EXPECT_FALSE(interrupts.asked());
}

TEST(InterruptsDeathTest, ASecondOneEndsIt) {
  EXPECT_EXIT(
      {
        const Interrupts interrupts;
        std::raise(SIGINT);
        std::raise(SIGINT);
      },
      testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace headway::app
