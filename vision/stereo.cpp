#include "vision/stereo.h"

#include <algorithm>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "vision/triangulation.h"
#include "vision/veil.h"

namespace headway::vision {

namespace {

// OpenCV's matchers would leave out more columns for a longer search.
DisparityRange search_range(RectifiedRig rig, const VisionConfig& config) {
  const DisparityRange asked = disparity_range(rig);
  if (config.matcher.kind != MatcherKind::kCensus) return asked;
  rig.nearest *= config.search_nearer;
  const int most = std::max(asked.count, Sgm::kMostDisparities);
  return {asked.lowest, std::min(disparity_range(rig).count, most)};
}

}  // namespace

StereoVision::StereoVision(const StereoRig& rig, const VisionConfig& config, hal::TwoProcessors& processors)
    : processors_(processors),
      rectifier_(rig, config.scale),
      doubt_(config.doubt),
      sigma_(config.sigma),
      weight_(config.weight),
      veils_(config.veils),
      searched_(search_range(rectifier_.rig(), config)),
      matcher_(make_matcher(searched_, config.matcher, processors)),
      sight_config_(config.sight) {
  sigma_.base = rectifier_.rig().disparity_sigma;
}

const RangeView& StereoVision::see(const hal::StereoFrame& frame, double farthest) {
  disparity_.resize(camera().width, camera().height);
  if (usable(frame))
    find_points(frame);
  else
    range_view(disparity_, rig(), view_);
  view_.far = std::max(view_.near, std::min(view_.far, farthest));
  return view_;
}

void StereoVision::find_points(const hal::StereoFrame& frame) try {
  rectifier_.rectify(frame.left, frame.right, left_, right_, processors_);
  matcher_->match(left_, right_, disparity_);
  processors_.both([&] { sight_ = check_sight(rectifier_, frame, left_, right_, sight_config_); },
                   [&] { weigh_matches(); });
} catch (const cv::Exception& e) {
  fault_ = fmt::format("the pair could not be matched: {}", e.err);
  disparity_.resize(camera().width, camera().height);
  range_view(disparity_, rig(), view_);
}

void StereoVision::weigh_matches() {
  estimate_doubt(doubt_, disparity_);
  estimate_sigma(sigma_, disparity_);
  estimate_weight(weight_, disparity_);
  range_view(disparity_, rig(), view_);
  drop_veils(disparity_, veils_, view_);
}

bool StereoVision::usable(const hal::StereoFrame& frame) {
  fault_.clear();
  if (rectifier_.accepts(frame.left, frame.right)) return true;
  const CameraIntrinsics& c = rectifier_.raw().left;
  fault_ = fmt::format("the images have {} x {} and {} x {} px, expected {} x {} each, as in rig {}",
                       frame.left.width, frame.left.height, frame.right.width, frame.right.height, c.width,
                       c.height, rectifier_.raw().name);
  return false;
}

}  // namespace headway::vision
