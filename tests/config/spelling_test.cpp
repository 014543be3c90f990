#include "config/spelling.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::config {
namespace {

RC_GTEST_PROP(Spelling, CountsAsManyLettersAsWereChangedAtMost, (std::string word)) {
  std::string changed = word;
  const auto edits = *rc::gen::inRange<std::size_t>(0, 5);
  for (std::size_t i = 0; i < edits; ++i) {
    const auto at = *rc::gen::inRange<std::size_t>(0, changed.size() + 1);
    if (at == changed.size() || *rc::gen::arbitrary<bool>())
      changed.insert(at, 1, 'x');
    else
      changed.erase(at, 1);
  }
  RC_ASSERT(letters_apart(word, changed) <= edits);
  RC_ASSERT(letters_apart(word, changed) == letters_apart(changed, word));
  RC_ASSERT((letters_apart(word, changed) == 0) == (word == changed));
}

TEST(Spelling, CountsAnExchangeOfNeighboursOnce) {
  EXPECT_EQ(letters_apart("nearset", "nearest"), 1U);
  EXPECT_EQ(letters_apart("ab", "ba"), 1U);
  EXPECT_EQ(letters_apart("", "abc"), 3U);
  EXPECT_EQ(letters_apart("focal", "vocal"), 1U);
}

TEST(Spelling, TakesTheNearestWordAndNoneThatIsFarOff) {
  EXPECT_EQ(meant_by("baselin", {"name", "baseline", "size"}), "baseline");
  EXPECT_EQ(meant_by("farthest", {"nearest"}), "");
  EXPECT_EQ(meant_by("cx", {"cy"}), "") << "too short to tell";
  EXPECT_EQ(meant_by("cam1", {"cam2"}), "") << "another number is another thing";
  EXPECT_EQ(meant_by("baseline", {}), "");
  EXPECT_EQ(meant_by("exposure", {"gain", "exposure_ms"}), "exposure_ms") << "the unit is missing";
  EXPECT_EQ(meant_by("rate_hz", {"gain", "rate"}), "rate") << "a unit too much";
  EXPECT_EQ(meant_by("velocity_rad_s", {"velocity", "velocity_deg_s"}), "velocity_deg_s") << "another unit";
  EXPECT_EQ(meant_by("tilt_deg", {"pan_rad", "tilt_rad"}), "tilt_rad");
  EXPECT_EQ(meant_by("wheel_radius", {"wheel_degree"}), "") << "no unit";
  EXPECT_EQ(meant_by("grey", {"GREY", "Y16"}), "GREY");
  EXPECT_EQ(meant_by("--white", {"--white-balance"}), "--white-balance");
  EXPECT_EQ(meant_by("exposure", {"exposures_taken"}), "") << "another word";
  EXPECT_EQ(meant_by("x", {"x_ms"}), "") << "too short to tell";
  EXPECT_EQ(meant_by(std::string(100'000, 'a'), {"baseline"}), "");
}

}  // namespace
}  // namespace headway::config
