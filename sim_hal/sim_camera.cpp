#include "sim_hal/sim_camera.h"

#include <utility>

#include <fmt/format.h>

#include "hal/error.h"
#include "sim_hal/camera_faults.h"
#include "sim_hal/noise.h"
#include "sim_hal/render.h"

namespace headway::sim {

namespace {

/// What is frozen is as it was in the last frame.
void repeat(const CameraFaults& wrong, hal::StereoFrame& frame, hal::StereoFrame& last) {
  const bool first = last.left.pixels.empty();
  if (wrong.frozen_picture && !first) frame.left = last.left, frame.right = last.right;
  if (wrong.frozen_stamp && !first) frame.exposure = last.exposure;
  last = frame;
}

void check(const Lens& lens, const char* eye) {
  if (lens.width < 1 || lens.height < 1 || lens.width > 8192 || lens.height > 8192)
    throw InputError(fmt::format("simulated {} camera: image of {} x {}, expected 1 to 8192 px each way", eye,
                                 lens.width, lens.height));
  if (!(lens.fx > 0) || !(lens.fy > 0))
    throw InputError(fmt::format("simulated {} camera: focal length {} x {} px, expected more than 0", eye,
                                 lens.fx, lens.fy));
}

}  // namespace

SimStereoCamera::SimStereoCamera(const Scene& scene, const hal::Clock& clock, StereoCameraModel model,
                                 const FaultSchedule* faults)
    : scene_(scene), clock_(clock), faults_(faults), model_(std::move(model)) {
  check(model_.left, "left");
  check(model_.right, "right");
  left_rays_ = ray_table(model_.left);
  right_rays_ = ray_table(model_.right);
}

void SimStereoCamera::expose(Time mid_exposure, const Eigen::Isometry3d& map_from_left_camera) {
  const CameraFaults wrong = faults_ ? camera_faults(*faults_, mid_exposure, sequence_) : CameraFaults{};
  if (wrong.lost) return lose_frame();
  const Imager imager = worsened(model_.imager, wrong);
  hal::StereoFrame frame;
  frame.exposure = mid_exposure;
  frame.sequence = sequence_++;
  render(scene_, model_.left, left_rays_, imager, map_from_left_camera,
         noise_key(model_.seed, frame.sequence, 0), frame.left);
  render(scene_, model_.right, right_rays_, imager, map_from_left_camera * model_.right_from_left.inverse(),
         noise_key(model_.seed, frame.sequence, 1), frame.right);
  if (wrong.swapped) std::swap(frame.left, frame.right);
  if (faults_) repeat(wrong, frame, last_);
  transfer_.put(mid_exposure, model_.transfer + wrong.late, std::move(frame));
}

bool SimStereoCamera::take_newest(hal::StereoFrame& into) {
  return transfer_.take_newest(clock_.now(), into);
}

}  // namespace headway::sim
