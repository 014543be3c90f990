// What the fuzzer of the head's master begins with, whole and broken at random: each promise in
// tests/fuzz/answer_bytes.h holds.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/fuzz/answer_bytes.h"
#include "tests/fuzz/mutation.h"

namespace headway::fuzz {
namespace {

TEST(DrivesAnswers, LeaveTheHeadInANamedStateHoweverMutated) {
  constexpr int kRounds = 500;
  const std::vector<std::string> whole = whole_answers();
  for (const std::string& input : whole) hear_answers(input);
  Mutation mutation(1);
  for (int round = 0; round < kRounds; ++round)
    hear_answers(mutation.of(whole[static_cast<std::size_t>(round) % whole.size()], whole));
}

}  // namespace
}  // namespace headway::fuzz
