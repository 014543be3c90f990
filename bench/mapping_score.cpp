#include "bench/mapping_score.h"

#include <cmath>

namespace headway::bench {

SeenRoom::SeenRoom(const Room& room, const std::vector<PosedView>& views, double resolution)
    : resolution_(resolution),
      size_(((highest() - lowest()) / resolution).array().round().cast<int>()),
      truth_(index({0, 0, size_.z()})) {
  std::vector<std::uint8_t> pixels(truth_.size()), seen(truth_.size());
  for (const PosedView& view : views) add_view(room, view, pixels, seen);
  const double to_corner = resolution * std::sqrt(3) / 2;
  constexpr int kEnoughPixels = 3;
  std::size_t i = 0;
  for (int z = 0; z < size_.z(); ++z) {
    for (int y = 0; y < size_.y(); ++y) {
      for (int x = 0; x < size_.x(); ++x, ++i) {
        const Eigen::Vector3d p = centre(x, y, z);
        const double clearance = room.clearance(p);
        unsigned truth = 0;
        for (const PosedView& view : views)
          if ((p - view.map_from_camera.translation()).squaredNorm() <= kFarthest * kFarthest)
            truth |= kInRange;
        if (pixels[i] >= kEnoughPixels) truth |= room.on_pole(p, resolution) ? kSurface | kPole : kSurface;
        if (clearance > to_corner + resolution) truth |= kFarFromSurfaces;
        if (clearance < -resolution / 2) truth |= kSolid;
        if (clearance > to_corner && seen[i] && pixels[i] == 0) truth |= kAir;
        truth_[i] = static_cast<std::uint8_t>(truth);
      }
    }
  }
}

// Counts the pixels that hit each voxel, and notes the voxels whose centres are seen.
void SeenRoom::add_view(const Room& room, const PosedView& posed, std::vector<std::uint8_t>& pixels,
                        std::vector<std::uint8_t>& seen) const {
  const vision::PinholeCamera& c = posed.view.camera;
  const Eigen::Isometry3d& pose = posed.map_from_camera;
  std::vector<double> depth(posed.view.depth.size());
  for (int v = 0; v < c.height; ++v) {
    for (int u = 0; u < c.width; ++u) {
      const Eigen::Vector3d ray = pose.linear() * c.point(u, v, 1);
      const double z = depth[posed.view.index(u, v)] = room.cast(pose.translation(), ray);
      if (z < kNearest || z * ray.norm() > kFarthest) continue;
      const Eigen::Vector3d behind_surface = pose.translation() + (z + 1e-6) * ray;
      const Eigen::Array3i i = ((behind_surface - lowest()) / resolution_).array().floor().cast<int>();
      if ((i < 0).any() || (i >= size_.array()).any()) continue;
      std::uint8_t& count = pixels[index(i)];
      if (count < 255) ++count;
    }
  }
  const Eigen::Isometry3d camera_from_map = pose.inverse();
  std::size_t i = 0;
  for (int z = 0; z < size_.z(); ++z) {
    for (int y = 0; y < size_.y(); ++y) {
      for (int x = 0; x < size_.x(); ++x, ++i) {
        const Eigen::Vector3d p = camera_from_map * centre(x, y, z);
        if (p.z() < kNearest || p.norm() > kFarthest - 0.1) continue;
        const double u = c.focal * p.x() / p.z() + c.cx, v = c.focal * p.y() / p.z() + c.cy;
        if (u < 2 || v < 2 || u > c.width - 3 || v > c.height - 3) continue;
        const double surface =
            depth[posed.view.index(static_cast<int>(std::lround(u)), static_cast<int>(std::lround(v)))];
        if (p.z() < surface - resolution_) seen[i] = 1;
      }
    }
  }
}

void SeenRoom::Counts::add(std::uint8_t truth, nav::Voxel voxel) {
  if (!(truth & kInRange)) return;
  const bool is_occupied = voxel == nav::Voxel::kOccupied, is_empty = voxel == nav::Voxel::kEmpty;
  if (truth & kSurface) ++surface, surface_occupied += is_occupied, surface_empty += is_empty;
  if (truth & kPole) ++pole, pole_occupied += is_occupied;
  if (truth & kAir) ++air, air_empty += is_empty;
  occupied += is_occupied;
  empty += is_empty;
  ghosts += is_occupied && (truth & kFarFromSurfaces);
  in_solid += is_empty && (truth & kSolid);
}

MapScore SeenRoom::Counts::score() const {
  const auto percent = [](std::size_t part, std::size_t all) {
    return all == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(all);
  };
  return {percent(surface_occupied, surface),
          percent(surface_empty, surface),
          percent(pole_occupied, pole),
          percent(ghosts, occupied),
          percent(in_solid, empty),
          percent(air_empty, air),
          occupied};
}

}  // namespace headway::bench
