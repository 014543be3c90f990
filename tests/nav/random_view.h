// A small room half known, with things in it, and a camera somewhere: made up by RapidCheck.
#pragma once

#include <cmath>

#include <rapidcheck.h>

#include "nav/voxel_map.h"
#include "synthetic_room.h"
#include "vision/polytope.h"

namespace headway::nav {

inline double between(double lowest, double highest) {
  return lowest + (highest - lowest) * *rc::gen::inRange(0, 1 << 20) / static_cast<double>(1 << 20);
}

/// A field like a rig's, from `near` to `far`; the right camera, `baseline` to the right, cuts off its left
/// side.
inline vision::Polytope rig_field(double tan_x, double tan_y, double near, double far,
                                  double baseline = 0.144) {
  const auto row = [](double x, double y, double z, double w) {
    return vision::half_space(Eigen::Vector4d(x, y, z, w));
  };
  return *vision::minimal_polytope({row(1, 0, tan_x, -baseline), row(-1, 0, tan_x, 0), row(0, 1, tan_y, 0),
                                    row(0, -1, tan_y, 0), row(0, 0, 1, -near), row(0, 0, -1, far)});
}

struct RandomView {
  VoxelMap map;
  vision::Polytope field;
  Eigen::Isometry3d pose;
};

inline void fill(VoxelMap& map, const VoxelMap::Index& low, const VoxelMap::Index& high, LogOdds value) {
  for (int z = low.z(); z < high.z(); ++z)
    for (int y = low.y(); y < high.y(); ++y)
      for (int x = low.x(); x < high.x(); ++x)
        if (map.contains({x, y, z})) map.set({x, y, z}, value, Time{});
}

/// 3.2 m x 3.2 m x 1.6 m in voxels of 10 cm.
inline RandomView any_view() {
  VoxelMapConfig config;
  config.resolution = 0.1;
  config.lowest = {-1.6, -1.6, 0};
  config.highest = {1.6, 1.6, 1.6};
  RandomView r{VoxelMap(config), {}, {}};
  const auto boxes = [&](int most, int size, LogOdds value) {
    for (int n = *rc::gen::inRange(0, most + 1); n > 0; --n) {
      const auto to = [](int end) { return *rc::gen::inRange(0, end); };
      const VoxelMap::Index low(to(32), to(32), to(16));
      fill(r.map, low, low + VoxelMap::Index(1 + to(size), 1 + to(size), 1 + to(size)), value);
    }
  };
  boxes(6, 16, log_odds::kLowest);
  boxes(8, 8, log_odds::kHighest);
  boxes(30, 1, log_odds::kHighest);
  boxes(6, 4, log_odds::kLowest);
  r.field = rig_field(between(0.2, 0.9), between(0.2, 0.7), between(0.3, 0.8), between(1.2, 3.5));
  r.pose = camera_pose({between(-1.7, 1.7), between(-1.7, 1.7), between(0.1, 1.7)}, between(-3.1, 3.1),
                       between(-0.8, 0.9)) *
           Eigen::AngleAxisd(between(-0.3, 0.3), Eigen::Vector3d::UnitZ());
  return r;
}

}  // namespace headway::nav
