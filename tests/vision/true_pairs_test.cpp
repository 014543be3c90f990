// The census matcher beside OpenCV's semi-global one on pairs with truth: real ones, and others that nothing
// was chosen with.
#include "tests/true_pairs/true_pairs.h"

#include <gtest/gtest.h>

#include "vision/disparity_sigma.h"
#include "vision/doubt.h"
#include "vision/evaluation.h"
#include "vision/match_weight.h"
#include "vision/matchers.h"

namespace headway::vision {
namespace {

MatchQuality quality(MatcherKind kind, const TruePair& pair, const hal::GrayImage& right) {
  MatcherConfig config;
  config.kind = kind;
  config.sgbm.uniqueness = 10;
  DisparityImage found;
  make_matcher({0, pair.disparities}, config)->match(pair.left, right, found);
  estimate_doubt({}, found);
  estimate_sigma({}, found);
  estimate_weight({}, found);
  return compare(found, pair.truth);
}

void expect_better(const TruePair& pair) {
  for (const hal::GrayImage* right : {&pair.right, &pair.right_askew}) {
    SCOPED_TRACE(pair.name + (right == &pair.right ? "" : ", half a row lower"));
    EXPECT_LT(quality(MatcherKind::kCensus, pair, *right).wrong_or_missing(),
              quality(MatcherKind::kSgbm, pair, *right).wrong_or_missing());
  }
}

TEST(RealPairs, AreMatchedBetterThanBySgbm) {
  const std::vector<TruePair> pairs = real_pairs();
  if (pairs.empty()) GTEST_SKIP() << "neither HEADWAY_DATA nor opencv-doc is here";
  for (const TruePair& pair : pairs) {
    expect_better(pair);
    EXPECT_GE(quality(MatcherKind::kCensus, pair, pair.right).weight_auc, 0.85)
        << pair.name << ": the weight tells right from wrong";
  }
}

TEST(HeldOutPairsSlow, AreMatchedBetterThanBySgbm) {
  for (const TruePair& pair : held_out_pairs()) expect_better(pair);
}

TEST(HeldOutPairsSlow, HaveLessWeightWhereTheyAreWrong) {
  for (const TruePair& pair : held_out_pairs())
    EXPECT_GE(quality(MatcherKind::kCensus, pair, pair.right).weight_auc, 0.85) << pair.name;
}

TEST(HeldOutPairsSlow, LieWithinThreeSigmaOfTheTruth) {
  for (const TruePair& pair : held_out_pairs())
    EXPECT_GE(quality(MatcherKind::kCensus, pair, pair.right).coverage_3_sigma, 0.97) << pair.name;
}

}  // namespace
}  // namespace headway::vision
