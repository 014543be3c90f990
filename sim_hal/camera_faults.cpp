#include "sim_hal/camera_faults.h"

#include <algorithm>
#include <cmath>

namespace headway::sim {

namespace {

constexpr double kDarkest = 0.1;         // share of the usual light below which the pictures count as covered
constexpr double kNoiseOfTheModel = 6;   // that doubles the variance of the disparity's error [grey levels]
constexpr double kNoiseThatBlinds = 40;  // with which nothing is matched any more [grey levels]

}  // namespace

CameraFaults camera_faults(const FaultSchedule& schedule, Time exposure, std::uint64_t sequence) {
  CameraFaults now;
  for (std::size_t i = 0; i < schedule.plan().size(); ++i) {
    if (!schedule.on(i, exposure)) continue;
    const Fault& fault = schedule.plan()[i];
    switch (fault.kind) {
      case FaultKind::kFrameLoss:
        now.lost = now.lost || schedule.draw(i, sequence) < fault.share;
        break;
      case FaultKind::kFrameDelay:
        now.late = std::max(now.late, fault.delay);
        break;
      case FaultKind::kFrozenPicture:
        now.frozen_picture = true;
        break;
      case FaultKind::kFrozenStamp:
        now.frozen_stamp = true;
        break;
      case FaultKind::kNoise:
        now.noise = std::hypot(now.noise, fault.noise);
        break;
      case FaultKind::kDark:
        now.light *= fault.light;
        break;
      case FaultKind::kSwapped:
        now.swapped = true;
        break;
      default:
        break;
    }
  }
  return now;
}

Imager worsened(const Imager& imager, const CameraFaults& faults) {
  Imager worse = imager;
  worse.noise_sigma = std::hypot(imager.noise_sigma, faults.noise);
  worse.exposure *= faults.light;
  return worse;
}

DepthCameraModel worsened(const DepthCameraModel& model, const CameraFaults& faults) {
  DepthCameraModel worse = model;
  if (faults.swapped || faults.light < kDarkest) {
    worse.missing = worse.missing_at_edges = 1;
  } else if (const double noise = faults.noise / faults.light; noise > 0) {
    worse.disparity_sigma *= std::hypot(1, noise / kNoiseOfTheModel);
    worse.missing = 1 - (1 - model.missing) * std::max(0.0, 1 - noise / kNoiseThatBlinds);
    worse.missing_at_edges = std::max(worse.missing, model.missing_at_edges);
  }
  return worse;
}

}  // namespace headway::sim
