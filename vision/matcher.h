// Stereo matching behind one interface, and OpenCV's semi-global matcher as the one there is now.
#pragma once

#include <memory>

#include "hal/frame.h"
#include "vision/disparity.h"
#include "vision/rectified_rig.h"

namespace headway::vision {

class Matcher {
 public:
  virtual ~Matcher() = default;
  /// Finds the disparity of each pixel of `left` in `right`: rectified images of one size. `out` is resized;
  /// pixels without a trustworthy match are NaN (all of them, when the sizes differ). Equal images give equal
  /// bytes. May throw what its library throws when memory runs out; StereoVision catches that.
  virtual void match(const hal::GrayImage& left, const hal::GrayImage& right, DisparityImage& out) = 0;
};

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

/// OpenCV's StereoSGBM. OpenCV divides the work by cv::setNumThreads(), a process-wide setting: the program
/// calls cv::setNumThreads(1) at its start where it wants one core; the result is the same for any number of
/// threads.
class SgbmMatcher final : public Matcher {
 public:
  explicit SgbmMatcher(DisparityRange range, const SgbmConfig& config = {});
  ~SgbmMatcher() override;

  void match(const hal::GrayImage& left, const hal::GrayImage& right, DisparityImage& out) override;
  const DisparityRange& range() const { return range_; }

 private:
  struct State;
  DisparityRange range_;
  std::unique_ptr<State> state_;
};

}  // namespace headway::vision
