// The last step of the census matcher: from fixed-point disparities and sums to pixels and ambiguities, many
// at a time.
#pragma once

#include <cstdint>

namespace headway::vision {

/// One row of what was found, by column.
struct FoundRow {
  const std::int16_t* disparity;  ///< 1/16 px above `lowest`; negative where there is none
  const std::uint8_t *least, *second, *disagreement;  ///< as in SgmResult
  const float* alone;                                 ///< how little it says to win in this column
  int width;
};

struct AmbiguityRules {
  float lowest = 0;          ///< [px]
  float most_ambiguous = 1;  ///< more than that is no match
  int agreeing = 2;  ///< views that disagree by more [px] are wrong as often as not, however clearly they won
  float doubtful = 0.95F;  ///< the ambiguity of those, at least
};

/// Writes disparities [px] and ambiguities, NaN where there is no match. Ambiguity is (least + 1) / (second +
/// 1), which is 1 where nothing tells one place from another; or more, where there are few rivals or the
/// views disagree. No match has its partner outside the right image.
void write_matches(const FoundRow& row, const AmbiguityRules& rules, float* disparities, float* ambiguities);

}  // namespace headway::vision
