// What the fuzzers of config files, frames and commands begin with, whole and broken at random: each promise
// in tests/fuzz/*_bytes.h holds.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/fuzz/command_bytes.h"
#include "tests/fuzz/config_bytes.h"
#include "tests/fuzz/frame_bytes.h"
#include "tests/fuzz/mutation.h"

namespace headway::fuzz {
namespace {

TEST(Configs, AreReadOrRefusedHoweverMutated) {
  constexpr int kRounds = 2000;
  const std::vector<std::string> whole = whole_configs();
  ASSERT_GE(whole.size(), config_readers().size());
  for (const std::string& input : whole) EXPECT_TRUE(is_config(input)) << input;
  Mutation mutation(1);
  int refused = 0;
  for (int round = 0; round < kRounds; ++round)
    refused += !is_config(mutation.of(whole[static_cast<std::size_t>(round) % whole.size()], whole));
  EXPECT_GT(refused, kRounds / 4);
}

TEST(FrameRows, ArePlainToWhoeverHearsThemHoweverMutated) {
  constexpr int kRounds = 5000;
  const std::vector<std::string> whole = whole_frame_rows();
  for (const std::string& input : whole) hear_frames(input);
  Mutation mutation(1);
  for (int round = 0; round < kRounds; ++round)
    hear_frames(mutation.of(whole[static_cast<std::size_t>(round) % whole.size()], whole));
}

TEST(OperatorsLines, AreAnsweredHoweverMutated) {
  constexpr int kRounds = 1000;
  const std::vector<std::string> whole = whole_commands();
  for (const std::string& input : whole) answer_lines(input);
  Mutation mutation(1);
  for (int round = 0; round < kRounds; ++round)
    answer_lines(mutation.of(whole[static_cast<std::size_t>(round) % whole.size()], whole));
}

}  // namespace
}  // namespace headway::fuzz
