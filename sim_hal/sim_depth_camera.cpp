#include "sim_hal/sim_depth_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "hal/error.h"
#include "sim_hal/camera_faults.h"
#include "sim_hal/noise.h"
#include "sim_hal/noise_field.h"
#include "sim_hal/render.h"

namespace headway::sim {

using Eigen::Isometry3d, Eigen::Matrix3f, Eigen::Vector2f, Eigen::Vector3f;

namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

void check(const DepthCameraModel& m) {
  const auto require = [](bool holds, const char* what, double value, const char* expected) {
    if (!holds)
      throw InputError(fmt::format("simulated depth camera: {} {}, expected {}", what, value, expected));
  };
  require(m.width >= 1 && m.width <= 8192, "width", m.width, "1 to 8192 px");
  require(m.height >= 1 && m.height <= 8192, "height", m.height, "1 to 8192 px");
  require(m.focal > 0, "focal length", m.focal, "more than 0 px");
  require(m.baseline > 0, "baseline", m.baseline, "more than 0 m");
  require(m.nearest > 0, "nearest distance", m.nearest, "more than 0 m");
  require(m.farthest > m.nearest, "farthest distance", m.farthest, "more than the nearest");
  require(m.disparity_sigma >= 0 && m.disparity_sigma <= 10, "disparity sigma", m.disparity_sigma,
          "0 to 10 px");
  require(m.correlation >= 0 && m.correlation <= 50, "correlation", m.correlation, "0 to 50 px");
  for (const double share : {m.outliers, m.missing, m.missing_at_edges})
    require(share >= 0 && share <= 1, "share", share, "0 to 1");
}

/// What is frozen is as it was in the last frame.
void repeat(const CameraFaults& wrong, hal::DepthFrame& frame, hal::DepthFrame& last) {
  const bool first = last.depth.empty();
  if (wrong.frozen_picture && !first) frame.depth = last.depth;
  if (wrong.frozen_stamp && !first) frame.exposure = last.exposure;
  last = frame;
}

Lens lens_of(const DepthCameraModel& m) { return Lens::pinhole(m.width, m.height, m.focal, m.cx, m.cy); }

}  // namespace

SimDepthCamera::SimDepthCamera(const Scene& scene, const hal::Clock& clock, DepthCameraModel model,
                               const FaultSchedule* faults)
    : scene_(scene), clock_(clock), faults_(faults), model_(model) {
  check(model_);
  rays_ = ray_table(lens_of(model_));
}

void SimDepthCamera::expose(Time mid_exposure, const Isometry3d& map_from_camera) {
  const CameraFaults wrong = faults_ ? camera_faults(*faults_, mid_exposure, sequence_) : CameraFaults{};
  if (wrong.lost) return lose_frame();
  hal::DepthFrame frame;
  frame.exposure = mid_exposure;
  frame.sequence = sequence_++;
  frame.width = model_.width;
  frame.height = model_.height;
  truth_ = true_depth(scene_, rays_, map_from_camera);
  frame.depth = seen_by_both(map_from_camera);
  add_errors(worsened(model_, wrong), frame.sequence, frame.depth);
  if (faults_) repeat(wrong, frame, last_);
  transfer_.put(mid_exposure, model_.transfer + wrong.late, std::move(frame));
}

bool SimDepthCamera::take_newest(hal::DepthFrame& into) { return transfer_.take_newest(clock_.now(), into); }

// The true depths where both eyes see the point within the range, NaN elsewhere.
std::vector<float> SimDepthCamera::seen_by_both(const Isometry3d& map_from_camera) const {
  const auto width = static_cast<std::size_t>(model_.width);
  const auto baseline = static_cast<float>(model_.baseline), near = static_cast<float>(model_.nearest),
             far = static_cast<float>(model_.farthest), fb = static_cast<float>(model_.focal) * baseline;
  const Matrix3f rotation = map_from_camera.linear().cast<float>();
  const Vector3f right_eye = (map_from_camera * Eigen::Vector3d(model_.baseline, 0, 0)).cast<float>();
  std::vector<float> depth(truth_.size(), kNothing);
  RayPacket packet;
  std::array<std::size_t, RayPacket::kSize> pixel{};
  packet.count = 0;
  const auto flush = [&] {
    const std::uint32_t seen = scene_.sees_points(right_eye, packet);
    for (std::size_t i = 0; i < static_cast<std::size_t>(packet.count); ++i)
      if ((seen >> i) & 1U) depth[pixel[i]] = truth_[pixel[i]];
    packet.count = 0;
  };
  for (std::size_t i = 0; i < truth_.size(); ++i) {
    const float z = truth_[i];
    if (!(z >= near && z <= far)) continue;
    if (static_cast<float>(i % width) - fb / z < 0) continue;
    const Vector3f to_point = rotation * Vector3f(rays_[i].x() * z - baseline, rays_[i].y() * z, z);
    const auto n = static_cast<std::size_t>(packet.count++);
    pixel[n] = i;
    packet.dx[n] = to_point.x(), packet.dy[n] = to_point.y(), packet.dz[n] = to_point.z();
    if (packet.count == RayPacket::kSize) flush();
  }
  if (packet.count > 0) flush();
  return depth;
}

// Does the true disparity jump by more than a pixel within two pixels of this one?
bool SimDepthCamera::at_edge(std::size_t index) const {
  const auto fb = static_cast<float>(model_.focal * model_.baseline);
  const int width = model_.width, u = static_cast<int>(index) % width, v = static_cast<int>(index) / width;
  const float here = fb / truth_[index];
  for (const auto& [du, dv] : {std::pair{-2, 0}, {-1, 0}, {1, 0}, {2, 0}, {0, -2}, {0, -1}, {0, 1}, {0, 2}}) {
    const int x = u + du, y = v + dv;
    if (x < 0 || y < 0 || x >= width || y >= model_.height) continue;
    // On a slanted surface the disparity changes steadily: what jumps is more than that.
    const float there =
        fb /
        truth_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    if (std::abs(there - here) > 1.0F * static_cast<float>(std::abs(du + dv))) return true;
  }
  return false;
}

void SimDepthCamera::add_errors(const DepthCameraModel& model, std::uint64_t sequence,
                                std::vector<float>& depth) const {
  enum : std::uint64_t { kError, kOutlier, kOutlierValue, kMissing };
  const auto key = [&](std::uint64_t what) { return noise_key(model.seed, sequence, 16 + what); };
  const auto fb = static_cast<float>(model.focal * model.baseline);
  const auto near = static_cast<float>(model.nearest), far = static_cast<float>(model.farthest),
             sigma = static_cast<float>(model.disparity_sigma);
  const std::vector<float> error = noise_field(model.width, model.height, model.correlation, key(kError));
  for (std::size_t i = 0; i < depth.size(); ++i) {
    float& z = depth[i];
    if (std::isnan(z)) continue;
    const double missing =
        model.missing_at_edges > model.missing && at_edge(i) ? model.missing_at_edges : model.missing;
    float disparity = fb / z + sigma * error[i];
    if (uniform(key(kOutlier), i) < model.outliers)
      disparity = fb / far + static_cast<float>(uniform(key(kOutlierValue), i)) * (fb / near - fb / far);
    z = disparity > 0 ? fb / disparity : kNothing;
    if (!(z >= near && z <= far) || uniform(key(kMissing), i) < missing) z = kNothing;
  }
}

}  // namespace headway::sim
