// Range mode: depth frames with the errors of a stereo rig, straight from the ray caster. For large
// campaigns.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "hal/camera.h"
#include "hal/clock.h"
#include "sim_hal/fault_schedule.h"
#include "sim_hal/lens.h"
#include "sim_hal/scene.h"
#include "sim_hal/transfer.h"

namespace headway::sim {

/// A rectified rig: the right camera lies `baseline` to the right (+x) of the left, both without distortion.
struct DepthCameraModel {
  int width = 240, height = 170;
  double focal = 200, cx = 119.5, cy = 84.5;  ///< [px]
  double baseline = 0.144;                    ///< [m]
  double nearest = 0.4, farthest = 6.0;       ///< Z that is measured [m]
  double disparity_sigma = 0.3;               ///< [px]
  double correlation = 0;   ///< distance over which the error's correlation falls to 1/e [px]; 0: none
  double outliers = 0.005;  ///< share of pixels with a disparity that has nothing to do with the scene
  double missing = 0.03;    ///< share of pixels without a value
  double missing_at_edges =
      0.5;  ///< the same where the disparity jumps by more than 1 px from pixel to pixel, within 2 px
  Duration transfer = std::chrono::milliseconds(20);
  std::uint64_t seed = 1;
};

/// As SimStereoCamera, for depth. NaN where the right camera cannot see what the left sees, as with real
/// stereo.
class SimDepthCamera final : public hal::DepthCamera {
 public:
  /// Scene, clock and faults (if any) must outlive the camera. Throws InputError when the model cannot be
  /// (sizes, ranges, shares).
  SimDepthCamera(const Scene& scene, const hal::Clock& clock, DepthCameraModel model,
                 const FaultSchedule* faults = nullptr);

  /// Measures the scene as it is now from the true pose of the rectified left camera (optical frame).
  void expose(Time mid_exposure, const Eigen::Isometry3d& map_from_camera);
  void lose_frame() { ++sequence_; }

  bool take_newest(hal::DepthFrame& into) override;

  const DepthCameraModel& model() const { return model_; }
  /// The last exposure without errors: Z [m], infinity where nothing is; also where the rig measures nothing.
  const std::vector<float>& truth() const { return truth_; }

 private:
  std::vector<float> seen_by_both(const Eigen::Isometry3d& map_from_camera) const;
  bool at_edge(std::size_t index) const;
  void add_errors(const DepthCameraModel& model, std::uint64_t sequence, std::vector<float>& depth) const;

  const Scene& scene_;
  const hal::Clock& clock_;
  const FaultSchedule* faults_;
  DepthCameraModel model_;
  std::vector<Eigen::Vector2f> rays_;
  std::vector<float> truth_;
  Transfer<hal::DepthFrame> transfer_;
  std::uint64_t sequence_ = 0;
  hal::DepthFrame last_;  ///< that was not lost; kept where faults may show it again
};

}  // namespace headway::sim
