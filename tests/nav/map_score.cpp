#include "map_score.h"

#include <cmath>

namespace headway::nav {
namespace {

struct Share {
  double yes = 0, all = 0;
  void add(bool is) {
    all += 1;
    yes += is;
  }
  double value() const { return all > 0 ? yes / all : 0; }
};

constexpr double kNear = 0.5, kFar = 5;

/// How many pixels of all views lie in each voxel of the map, row-major x fastest.
std::vector<int> pixels_per_voxel(const VoxelMap& map, const SyntheticRoom& room,
                                  const vision::PinholeCamera& camera,
                                  const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<int> count(static_cast<std::size_t>(map.size().cast<long>().prod()));
  for (const Eigen::Isometry3d& pose : poses) {
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const Eigen::Vector3d ray = pose.linear() * camera.point(u, v, 1);
        const double z = room.cast(pose.translation(), ray);
        const VoxelMap::Index i = map.index(pose.translation() + z * ray);
        if (z < kNear || z > kFar || !map.contains(i)) continue;
        ++count[static_cast<std::size_t>((i.z() * map.size().y() + i.y()) * map.size().x() + i.x())];
      }
    }
  }
  return count;
}

bool in_view(const Eigen::Vector3d& point, const SyntheticRoom& room, const vision::PinholeCamera& camera,
             const std::vector<Eigen::Isometry3d>& poses) {
  for (const Eigen::Isometry3d& pose : poses) {
    const Eigen::Vector3d c = pose.inverse() * point;
    if (c.z() < kNear + 0.1 || c.z() > kFar - 0.2) continue;
    const double u = camera.focal * c.x() / c.z() + camera.cx, v = camera.focal * c.y() / c.z() + camera.cy;
    if (u < 2 || v < 2 || u > camera.width - 3 || v > camera.height - 3) continue;
    if (room.cast(pose.translation(), point - pose.translation()) > 1) return true;
  }
  return false;
}

bool on_pole(const Eigen::Vector3d& p, double reach) {
  return std::abs(p.x() - 1.1) < reach && std::abs(p.y() - 1.43) < reach && p.z() > 0.1 && p.z() < 2.4;
}

}  // namespace

MapScore score(const VoxelMap& map, const SyntheticRoom& room, const vision::PinholeCamera& camera,
               const std::vector<Eigen::Isometry3d>& poses) {
  const std::vector<int> pixels = pixels_per_voxel(map, room, camera, poses);
  Share occupied, emptied, air, air_occupied, solid, pole;
  std::size_t i = 0;
  for (int z = 0; z < map.size().z(); ++z) {
    for (int y = 0; y < map.size().y(); ++y) {
      for (int x = 0; x < map.size().x(); ++x, ++i) {
        const Eigen::Vector3d p = map.centre({x, y, z});
        const Voxel voxel = map.at({x, y, z});
        const double clearance = room.clearance(p);
        if (on_pole(p, 0.015 + map.resolution() / 2)) {
          if (pixels[i] > 0) pole.add(voxel == Voxel::kOccupied);
        } else if (pixels[i] >= 3) {
          occupied.add(voxel == Voxel::kOccupied);
          emptied.add(voxel == Voxel::kEmpty);
        }
        if (clearance < -map.resolution()) solid.add(voxel == Voxel::kEmpty);
        const bool every_seventh = i % 7 == 0;  // each costs a ray per view
        if (clearance > 0.1 && every_seventh && in_view(p, room, camera, poses)) {
          air.add(voxel == Voxel::kEmpty);
          air_occupied.add(voxel == Voxel::kOccupied);
        }
      }
    }
  }
  return {occupied.value(), emptied.value(), air.value(), air_occupied.value(), solid.value(), pole.value()};
}

}  // namespace headway::nav
