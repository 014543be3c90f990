// The matcher of our own: census and slope of the grey values, semi-global matching along four paths. Faster
// than OpenCV's semi-global matcher, with fewer errors, hardly disturbed by a camera that is brighter or half
// a row off; and it says of each match how clearly it won.
#pragma once

#include "hal/two_processors.h"
#include "vision/disparity_filters.h"
#include "vision/matcher.h"
#include "vision/rectified_rig.h"
#include "vision/sgm.h"

namespace headway::vision {

struct CensusConfig {
  SgmPenalties penalties;
  /// Largest disagreement of the left and right view [px]. Wide: most that disagree by a few pixels are
  /// right, and how clearly a match won tells them better.
  int left_right_difference = 8;
  double most_ambiguous = 0.995;  ///< matches with a DisparityImage::ambiguity above that are dropped
  int speckle_size = 100;         ///< patches of up to this many pixels are dropped
  double speckle_range = 2;       ///< disparity step that separates patches [px]
  /// Also columns whose search would leave the right image, as far as it reaches. OpenCV's matchers leave
  /// them out.
  bool borders = true;
};

/// Takes memory when the images' size changes, never between. The same bytes on every processor, and on one
/// or two.
class CensusMatcher final : public Matcher {
 public:
  /// Throws InputError unless `range.count` is a multiple of 16 up to 256 and the configuration makes sense.
  explicit CensusMatcher(DisparityRange range, const CensusConfig& config = {},
                         hal::TwoProcessors& processors = hal::one_processor());

  void match(const hal::GrayImage& left, const hal::GrayImage& right, DisparityImage& out) override;

 private:
  void weigh_columns(int width);
  void write(DisparityImage& out) const;

  DisparityRange range_;
  CensusConfig config_;
  hal::TwoProcessors& processors_;
  Sgm sgm_;
  SgmResult found_;
  std::vector<std::int16_t> smooth_;
  std::vector<float> alone_;
  SpeckleFilter speckles_;
};

}  // namespace headway::vision
