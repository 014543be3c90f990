// A stereo camera in the simulated world: real, unrectified images, rendered through each lens.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "hal/camera.h"
#include "hal/clock.h"
#include "sim_hal/fault_schedule.h"
#include "sim_hal/imager.h"
#include "sim_hal/lens.h"
#include "sim_hal/scene.h"
#include "sim_hal/transfer.h"

namespace headway::sim {

struct StereoCameraModel {
  Lens left, right;
  Eigen::Isometry3d right_from_left = Eigen::Isometry3d::Identity();
  Imager imager;
  Duration transfer = std::chrono::milliseconds(20);  ///< from mid-exposure to when the frame can be taken
  std::uint64_t seed = 1;                             ///< of the sensors' noise
};

/// Renders at the exposure and hands over after the transfer. The noise depends on (seed, sequence, eye,
/// pixel) only.
class SimStereoCamera final : public hal::StereoCamera {
 public:
  /// Scene, clock and faults (if any) must outlive the camera. Throws InputError when a size or a focal
  /// length is not positive.
  SimStereoCamera(const Scene& scene, const hal::Clock& clock, StereoCameraModel model,
                  const FaultSchedule* faults = nullptr);

  /// Exposes both eyes on the scene as it is now, from the true pose of the left camera (optical frame).
  void expose(Time mid_exposure, const Eigen::Isometry3d& map_from_left_camera);
  /// Counts a frame that is never delivered (a fault on demand).
  void lose_frame() { ++sequence_; }

  bool take_newest(hal::StereoFrame& into) override;

  const StereoCameraModel& model() const { return model_; }

 private:
  const Scene& scene_;
  const hal::Clock& clock_;
  const FaultSchedule* faults_;
  StereoCameraModel model_;
  std::vector<Eigen::Vector2f> left_rays_, right_rays_;
  Transfer<hal::StereoFrame> transfer_;
  std::uint64_t sequence_ = 0;
  hal::StereoFrame last_;  ///< that was not lost; kept where faults may show it again
};

}  // namespace headway::sim
