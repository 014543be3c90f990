// The whole of vision: a pair of raw images in, uncertain points out.
#pragma once

#include <limits>
#include <memory>
#include <string>

#include "hal/frame.h"
#include "hal/two_processors.h"
#include "vision/disparity_sigma.h"
#include "vision/doubt.h"
#include "vision/match_weight.h"
#include "vision/matchers.h"
#include "vision/range_view.h"
#include "vision/rectify.h"
#include "vision/rig.h"
#include "vision/sight_check.h"
#include "vision/veil.h"

namespace headway::vision {

struct VisionConfig {
  static constexpr double kSmallestScale = 0.1;
  double scale = 1;  ///< of the matched images: 0.5 is four times faster and half as precise
  MatcherConfig matcher;
  /// The census matcher searches up to this share of the rig's nearest depth, as far as it can. What stands
  /// nearer than `nearest` then finds its true partner and is left out, where it would find a wrong one far
  /// away.
  double search_nearer = 0.7;
  VeilFilter veils;
  DoubtModel doubt;
  SigmaModel sigma;  ///< its `base` is replaced by the rig's disparity_sigma
  WeightModel weight;
  SightConfig sight;
};

/// Rectifies, matches and triangulates. Everything is in the rectified left camera's optical frame; compose
/// with `left_from_rectified` to come to the raw left camera's.
class StereoVision {
 public:
  /// Throws InputError for an unusable rig or configuration. The processors must outlive it; what is seen is
  /// the same on one and on two.
  explicit StereoVision(const StereoRig& rig, const VisionConfig& config = {},
                        hal::TwoProcessors& processors = hal::one_processor());

  /// What the pair shows. The view stays valid until the next call. A pair that cannot be used (wrong size)
  /// gives a view without points, and `fault` says why; never throws because of an image. Beyond `farthest`
  /// [m], where that is nearer than the rig's, the view tells no more than that rays are empty up to there.
  const RangeView& see(const hal::StereoFrame& frame,
                       double farthest = std::numeric_limits<double>::infinity());

  const std::string& fault() const { return fault_; }  ///< empty when the last pair was used

  /// How the cameras saw the last pair that was used; empty before the first.
  const SightReport& sight() const { return sight_; }

  /// Of the last pair, for pictures.
  const hal::GrayImage& rectified_left() const { return left_; }
  const hal::GrayImage& rectified_right() const { return right_; }
  const DisparityImage& disparity() const { return disparity_; }

  /// What the matcher searches: the census matcher more than the rig's nearest depth asks for.
  const DisparityRange& searched() const { return searched_; }

  const RectifiedRig& rig() const { return rectifier_.rig(); }
  const PinholeCamera& camera() const { return rectifier_.camera(); }
  Eigen::Isometry3d left_from_rectified() const { return rectifier_.rectified_from_left().inverse(); }

 private:
  bool usable(const hal::StereoFrame& frame);
  void find_points(const hal::StereoFrame& frame);
  void weigh_matches();

  hal::TwoProcessors& processors_;
  Rectifier rectifier_;
  DoubtModel doubt_;
  SigmaModel sigma_;
  WeightModel weight_;
  VeilFilter veils_;
  DisparityRange searched_;
  std::unique_ptr<Matcher> matcher_;
  hal::GrayImage left_, right_;
  DisparityImage disparity_;
  RangeView view_;
  std::string fault_;
  SightConfig sight_config_;
  SightReport sight_;
};

}  // namespace headway::vision
