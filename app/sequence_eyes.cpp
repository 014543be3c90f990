#include "app/sequence_eyes.h"

#include <fmt/format.h>

#include "app/report.h"
#include "hal/error.h"
#include "vision/image_files.h"

namespace headway::app {

namespace {
constexpr DepthRange kDepthCamera{0.4, 5.0};
}

SequenceEyes::SequenceEyes(const Sequence& sequence, std::optional<double> near, std::optional<double> far,
                           const vision::VisionConfig& vision)
    : depth_camera_(sequence.camera), depth_per_metre_(sequence.depth_per_metre) {
  range_ = sequence.rig ? DepthRange{sequence.rig->nearest, sequence.rig->farthest} : kDepthCamera;
  if (near) range_.near = *near;
  if (far) range_.far = *far;
  if (!(range_.near > 0 && range_.near < range_.far)) {
    throw InputError(
        fmt::format("--near {:g} and --far {:g}: expected 0 < near < far [m]", range_.near, range_.far));
  }
  if (!sequence.rig) return;
  vision::StereoRig rig = *sequence.rig;
  rig.nearest = range_.near;
  rig.farthest = range_.far;
  stereo_ = std::make_unique<vision::StereoVision>(rig, vision);
}

const vision::PinholeCamera& SequenceEyes::camera() const {
  return stereo_ ? stereo_->camera() : depth_camera_;
}

SequenceEyes::Look SequenceEyes::look(const SequenceFrame& frame) {
  Look look;
  look.world_from_view = frame.world_from_camera;
  look.view = stereo_ ? &see_pair(frame, look) : &see_depth(frame, look);
  return look;
}

const vision::RangeView& SequenceEyes::see_pair(const SequenceFrame& frame, Look& look) {
  Stopwatch watch;
  pair_.exposure = frame.stamp;
  pair_.left = vision::read_gray(frame.left);
  pair_.right = vision::read_gray(frame.right);
  look.read_ms = watch.lap_ms();
  const vision::RangeView& view = stereo_->see(pair_);
  look.see_ms = watch.lap_ms();
  if (!stereo_->fault().empty()) throw InputError(frame.left.string() + ": " + stereo_->fault());
  look.left = &stereo_->rectified_left();
  look.fault = stereo_->sight().fault();
  look.world_from_view = frame.world_from_camera * stereo_->left_from_rectified();
  return view;
}

const vision::RangeView& SequenceEyes::see_depth(const SequenceFrame& frame, Look& look) {
  Stopwatch watch;
  hal::DepthFrame depth = vision::read_depth(frame.left, depth_per_metre_);
  depth.exposure = frame.stamp;
  look.read_ms = watch.lap_ms();
  if (depth.width != depth_camera_.width || depth.height != depth_camera_.height) {
    throw InputError(fmt::format("{}: has {} x {} px, expected {} x {} as the first image",
                                 frame.left.string(), depth.width, depth.height, depth_camera_.width,
                                 depth_camera_.height));
  }
  view_ = vision::range_view(depth, depth_camera_, range_.near, range_.far, vision::DepthCameraSigma{});
  look.see_ms = watch.lap_ms();
  return view_;
}

}  // namespace headway::app
