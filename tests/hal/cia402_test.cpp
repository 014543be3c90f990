#include "hal/cia402.h"

#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::hal::cia402 {
namespace {

TEST(Statusword, ShowsExactlyOneStateForEveryWordThatShowsAny) {
  for (unsigned word = 0; word < 0x80; ++word) {
    int fits = 0;
    for (const StateCode& code : kStateCodes) fits += (word & code.mask) == code.value;
    EXPECT_LE(fits, 1) << word;
  }
}

TEST(Statusword, IsReadWhateverTheOtherBitsSay) {
  for (const StateCode& code : kStateCodes) {
    for (unsigned others = 0; others < 0x10000; others += 7) {
      const auto word = static_cast<std::uint16_t>((others & ~unsigned{code.mask}) | code.value);
      ASSERT_EQ(state_of(word), code.state) << word;
    }
  }
}

// Figure "command coding" of the standard, written as patterns (bits 7, 3, 2, 1, 0; x: does not matter).
TEST(Controlword, GivesTheCommandsOfTheStandard) {
  EXPECT_EQ(command_of(0x0006), Command::kShutdown);
  EXPECT_EQ(command_of(0x000E), Command::kShutdown);
  EXPECT_EQ(command_of(0x0007), Command::kSwitchOn);
  EXPECT_EQ(command_of(0x000F), Command::kEnableOperation);
  EXPECT_EQ(command_of(0x003F), Command::kEnableOperation);
  EXPECT_EQ(command_of(0x0000), Command::kDisableVoltage);
  EXPECT_EQ(command_of(0x000D), Command::kDisableVoltage);
  EXPECT_EQ(command_of(0x0002), Command::kQuickStop);
  EXPECT_EQ(command_of(0x000B), Command::kQuickStop);
  EXPECT_EQ(command_of(0x0080), Command::kFaultReset);
  for (const CommandCode& code : kCommandCodes) {
    if (code.command == Command::kDisableOperation) continue;  // has the bits of "switch on"
    EXPECT_EQ(command_of(code_of(code.command)), code.command);
  }
}

TEST(Transitions, CarryTheNumbersOneToSixteenOnce) {
  std::set<int> numbers;
  for (const Transition& t : kTransitions) numbers.insert(t.number);
  EXPECT_EQ(numbers.size(), 16u);
  EXPECT_EQ(*numbers.begin(), 1);
  EXPECT_EQ(*numbers.rbegin(), 16);
}

TEST(Transitions, LeadFromEveryStateToOperationEnabled) {
  for (const StateCode& code : kStateCodes) {
    State state = code.state;
    for (int i = 0; i < 6 && state != State::kOperationEnabled; ++i) {
      // The two states that a drive leaves by itself.
      if (state == State::kNotReadyToSwitchOn) state = State::kSwitchOnDisabled;
      if (state == State::kFaultReactionActive) state = State::kFault;
      state = after(state, towards_operation(state));
    }
    EXPECT_EQ(state, State::kOperationEnabled) << static_cast<int>(code.state);
  }
}

TEST(Transitions, NothingButAFaultResetLeavesFault) {
  for (const CommandCode& code : kCommandCodes) {
    const bool leaves = after(State::kFault, code.command) != State::kFault;
    EXPECT_EQ(leaves, code.command == Command::kFaultReset);
  }
}

TEST(Transitions, NoCommandGivesTorqueAtOnceToADriveAtRest) {
  for (const CommandCode& code : kCommandCodes) {
    for (const State s : {State::kSwitchOnDisabled, State::kReadyToSwitchOn, State::kFault}) {
      EXPECT_NE(after(s, code.command), State::kOperationEnabled);
    }
  }
}

TEST(ObjectDictionary, MapsObjectsAsTheStandardWritesThem) {
  static_assert(mapping_of(object::kControlword) == 0x60400010);
  static_assert(mapping_of(object::kMode) == 0x60600008);
  static_assert(mapping_of(object::kTarget) == 0x607A0020);
  static_assert(mapping_of(object::kStatusword) == 0x60410010);
  static_assert(mapping_of(object::kPosition) == 0x60640020);
  static_assert(sdo::download(1) == 0x2F && sdo::download(2) == 0x2B && sdo::download(4) == 0x23);
  static_assert(sdo::uploaded(1) == 0x4F && sdo::uploaded(2) == 0x4B && sdo::uploaded(4) == 0x43);
}

}  // namespace
}  // namespace headway::hal::cia402
