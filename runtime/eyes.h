// A camera and what makes uncertain points of its frames, as the frame loop uses them.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "hal/camera.h"
#include "hal/two_processors.h"
#include "vision/stereo.h"
#include "vision/triangulation.h"

namespace headway::runtime {

struct FrameStamp {
  Time exposure{};
  std::uint64_t sequence = 0;
};

/// How much is made of a frame.
struct Effort {
  bool half = false;  ///< the images are matched at half their size, where there is anything to match
  double farthest =
      std::numeric_limits<double>::infinity();  ///< depth Z beyond which nothing need be known [m]
};

class Eyes {
 public:
  virtual ~Eyes() = default;
  /// Takes the newest frame, if there is one that was not taken before.
  virtual std::optional<FrameStamp> take() = 0;
  /// From the next see() on.
  virtual void look_with(const Effort&) {}
  /// The points of the frame taken last, in the frame of `left_from_view`; valid until the next call.
  virtual const vision::RangeView& see() = 0;
  /// From the view's (rectified) frame to that of the left camera.
  virtual Eigen::Isometry3d left_from_view() const = 0;
  /// What the left camera saw, rectified; null for eyes without pictures.
  virtual const hal::GrayImage* picture() const { return nullptr; }
  /// Why the frame seen last cannot be used; empty when it can.
  virtual const std::string& fault() const = 0;
};

/// Of a picture that is, to the last bit, the one before: no sensor takes the same twice.
inline const std::string kFrozen = "the picture is the one before again: the camera is frozen";

/// Two cameras and a matcher; and another for images of half the size, whose points are as many fewer and as
/// much less sure.
class StereoEyes final : public Eyes {
 public:
  StereoEyes(hal::StereoCamera& camera, const vision::StereoRig& rig, const vision::VisionConfig& config,
             hal::TwoProcessors& processors = hal::one_processor())
      : camera_(camera), whole_(rig, config, processors), half_(rig, halved(config), processors) {}

  std::optional<FrameStamp> take() override {
    if (!camera_.take_newest(next_)) return std::nullopt;
    std::swap(frame_, next_);
    frozen_ = frame_.left.pixels == next_.left.pixels || frame_.right.pixels == next_.right.pixels;
    return FrameStamp{frame_.exposure, frame_.sequence};
  }
  void look_with(const Effort& effort) override {
    vision_ = effort.half ? &half_ : &whole_;
    farthest_ = effort.farthest;
  }
  const vision::RangeView& see() override { return vision_->see(frame_, farthest_); }
  Eigen::Isometry3d left_from_view() const override { return vision_->left_from_rectified(); }
  const hal::GrayImage* picture() const override { return &vision_->rectified_left(); }
  /// How the cameras saw the frame seen last.
  const vision::SightReport& sight() const { return vision_->sight(); }
  /// Of the images, or of the cameras as they see at the moment.
  const std::string& fault() const override {
    if (!vision_->fault().empty()) return vision_->fault();
    if (const vision::SightFinding* sight = vision_->sight().fault()) return sight->what;
    return frozen_ ? kFrozen : vision_->fault();
  }

 private:
  static vision::VisionConfig halved(vision::VisionConfig config) {
    config.scale = std::max(config.scale / 2, vision::VisionConfig::kSmallestScale);
    return config;
  }

  hal::StereoCamera& camera_;
  vision::StereoVision whole_, half_;
  vision::StereoVision* vision_ = &whole_;
  double farthest_ = std::numeric_limits<double>::infinity();
  hal::StereoFrame frame_, next_;  ///< `next_`: between two calls, the frame before
  bool frozen_ = false;
};

/// A depth camera, or the simulator's range mode, mounted in place of a rectified left camera.
class DepthEyes final : public Eyes {
 public:
  struct Config {
    vision::PinholeCamera camera;
    double near = 0.3, far = 6;  ///< [m]
    vision::DepthSigma sigma;
    Eigen::Isometry3d left_from_view = Eigen::Isometry3d::Identity();
  };
  DepthEyes(hal::DepthCamera& camera, const Config& config) : camera_(camera), config_(config) {}

  std::optional<FrameStamp> take() override {
    if (!camera_.take_newest(next_)) return std::nullopt;
    std::swap(frame_, next_);
    return FrameStamp{frame_.exposure, frame_.sequence};
  }
  void look_with(const Effort& effort) override { farthest_ = effort.farthest; }
  const vision::RangeView& see() override {
    view_ = vision::range_view(frame_, config_.camera, config_.near, std::min(config_.far, farthest_),
                               config_.sigma);
    fault_.clear();
    if (frame_.width != config_.camera.width || frame_.height != config_.camera.height ||
        frame_.depth.size() != view_.depth.size())
      fault_ = "the depth image has " + size_text(frame_.width, frame_.height) + ", expected " +
               size_text(config_.camera.width, config_.camera.height);
    else if (repeats())
      fault_ = kFrozen;
    return view_;
  }
  Eigen::Isometry3d left_from_view() const override { return config_.left_from_view; }
  const std::string& fault() const override { return fault_; }

 private:
  /// Bit by bit, for what was not measured equals nothing.
  bool repeats() const {
    const auto bits = [](float z) { return std::bit_cast<std::uint32_t>(z); };
    return std::ranges::equal(frame_.depth, next_.depth, {}, bits, bits) &&
           !std::ranges::all_of(frame_.depth, [](float z) { return std::isnan(z); });
  }
  static std::string size_text(int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height) + " px";
  }

  hal::DepthCamera& camera_;
  Config config_;
  double farthest_ = std::numeric_limits<double>::infinity();
  hal::DepthFrame frame_, next_;  ///< as StereoEyes
  vision::RangeView view_;
  std::string fault_;
};

}  // namespace headway::runtime
