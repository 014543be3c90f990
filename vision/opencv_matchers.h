// OpenCV's semi-global and block matchers behind our interface.
#pragma once

#include <memory>

#include "vision/matcher.h"
#include "vision/rectified_rig.h"

namespace headway::vision {

/// Of StereoSGBM (MODE_SGBM_3WAY), values in OpenCV's units. Chosen on Motorcycle for few gross errors while
/// most of what both cameras see is matched: 94.4 % matched, 5.4 % of it off by more than 2 px. Uniqueness 10
/// would lose 0.3 % of the matches for 0.2 % fewer gross errors; block 5 loses a full percent of the matches
/// for no fewer; p2 of 600 and more smears over edges (6.2 %).
struct SgbmConfig {
  int block = 3;                  ///< side of the matched block [px]
  int p1 = 72, p2 = 288;          ///< cost of a disparity step of one, and of more
  int prefilter_cap = 31;         ///< clips the horizontal gradient that is compared
  int uniqueness = 5;             ///< the best must beat all others by this many percent
  int left_right_difference = 1;  ///< largest disagreement of the left and right view [px]
  int speckle_size = 100;         ///< patches of up to this many pixels are dropped
  int speckle_range = 2;          ///< disparity step that separates patches [px]
};

/// Of StereoBM: the matcher of the smallest budget, half of StereoSGBM's, with four fifths of the matches.
struct BmConfig {
  int block = 9;                  ///< side of the matched block [px]
  int prefilter_cap = 31;         ///< clips the horizontal gradient that is compared
  int texture = 10;               ///< blocks with less are not matched
  int uniqueness = 10;            ///< the best must beat all others by this many percent
  int left_right_difference = 1;  ///< largest disagreement of the left and right view [px]
  int speckle_size = 100;         ///< patches of up to this many pixels are dropped
  int speckle_range = 2;          ///< disparity step that separates patches [px]
};

/// OpenCV's StereoSGBM and StereoBM. OpenCV divides the work by cv::setNumThreads(), a process-wide setting:
/// the program calls cv::setNumThreads(1) at its start where it wants one core; the result is the same for
/// any number of threads.
class OpencvMatcher : public Matcher {
 public:
  ~OpencvMatcher() override;
  void match(const hal::GrayImage& left, const hal::GrayImage& right, DisparityImage& out) override;

 protected:
  struct State;
  OpencvMatcher(DisparityRange range, std::unique_ptr<State> state);

 private:
  DisparityRange range_;
  std::unique_ptr<State> state_;
};

class SgbmMatcher final : public OpencvMatcher {
 public:
  /// Throws InputError for parameters that OpenCV does not take.
  explicit SgbmMatcher(DisparityRange range, const SgbmConfig& config = {});
};

class BmMatcher final : public OpencvMatcher {
 public:
  /// Throws InputError for parameters that OpenCV does not take.
  explicit BmMatcher(DisparityRange range, const BmConfig& config = {});
};

}  // namespace headway::vision
