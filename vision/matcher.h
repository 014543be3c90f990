// Stereo matching behind one interface.
#pragma once

#include "hal/frame.h"
#include "vision/disparity.h"

namespace headway::vision {

class Matcher {
 public:
  virtual ~Matcher() = default;
  /// Finds the disparity of each pixel of `left` in `right`: rectified images of one size. `out` is resized;
  /// pixels without a trustworthy match are NaN (all of them, when the sizes differ). Equal images give equal
  /// bytes. May throw what its library throws when memory runs out; StereoVision catches that.
  virtual void match(const hal::GrayImage& left, const hal::GrayImage& right, DisparityImage& out) = 0;
};

}  // namespace headway::vision
