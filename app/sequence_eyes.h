// Looks at the frames of a recorded sequence, whatever it was recorded with.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "app/sequence.h"
#include "hal/frame.h"
#include "vision/range_view.h"
#include "vision/stereo.h"
#include "vision/triangulation.h"

namespace headway::app {

struct DepthRange {
  double near = 0, far = 0;  ///< [m]
};

class SequenceEyes {
 public:
  /// The rig's own limits, or a depth camera's 0.4 to 5 m, unless `near` or `far` say otherwise. Throws
  /// InputError.
  SequenceEyes(const Sequence& sequence, std::optional<double> near, std::optional<double> far,
               const vision::VisionConfig& vision = {});

  struct Look {
    const vision::RangeView* view = nullptr;      ///< valid until the next look
    const hal::GrayImage* left = nullptr;         ///< rectified; null for depth images
    const vision::SightFinding* fault = nullptr;  ///< why depth from a pair is not to be trusted, if so
    Eigen::Isometry3d world_from_view = Eigen::Isometry3d::Identity();
    double read_ms = 0, see_ms = 0;
  };
  /// Throws InputError for images that cannot be read or have the wrong size.
  Look look(const SequenceFrame& frame);

  const vision::PinholeCamera& camera() const;
  DepthRange range() const { return range_; }

 private:
  const vision::RangeView& see_pair(const SequenceFrame& frame, Look& look);
  const vision::RangeView& see_depth(const SequenceFrame& frame, Look& look);

  DepthRange range_;
  std::unique_ptr<vision::StereoVision> stereo_;  ///< null for depth images
  vision::PinholeCamera depth_camera_;
  double depth_per_metre_;
  vision::RangeView view_;
  hal::StereoFrame pair_;
};

}  // namespace headway::app
