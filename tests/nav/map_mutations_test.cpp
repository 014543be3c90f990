// Whole map files of every format, broken at random: a clear refusal or a whole map, never anything else.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/fuzz/map_bytes.h"
#include "tests/fuzz/mutation.h"

namespace headway::fuzz {
namespace {

constexpr int kRounds = 12000;  // a second

TEST(MapFiles, AreReadOrRefusedHoweverMutated) {
  const std::vector<std::string> whole = whole_inputs();
  ASSERT_GE(whole.size(), readers().size());
  for (const std::string& input : whole)
    EXPECT_TRUE(is_map(input)) << "reader " << static_cast<int>(input[0]);
  Mutation mutation(1);
  std::vector<int> refused(whole.size());
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t input = static_cast<std::size_t>(round) % whole.size();
    refused[input] += !is_map(mutation.of(whole[input], whole));
  }
  for (const int n : refused) {
    EXPECT_GT(n, kRounds / 100);
    EXPECT_LT(n, kRounds / static_cast<int>(whole.size()));
  }
}

}  // namespace
}  // namespace headway::fuzz
