#include "nav/brick_update.h"

#include <algorithm>
#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/brick_update.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "nav/box_classes.inl"
#include "nav/cube_update.inl"

// Everything above HWY_ONCE is compiled once for each instruction set. Only exact operations are used (no
// approximate reciprocals, no fused sums), so that all of them give the same bytes.
HWY_BEFORE_NAMESPACE();
namespace headway::nav {

#ifndef HEADWAY_FOOT_MASKS
#define HEADWAY_FOOT_MASKS
namespace {

FootMasks foot_masks(const VoxelMap& map, int first_layer);

}  // namespace
#endif

namespace HWY_NAMESPACE {
namespace {

/// The bricks [first, last] of a row along x whose middles may lie in view.
struct Span {
  int first, last;
};
HWY_INLINE Span bricks_of_row(const Sweep& s, float y, float z) {
  float first = static_cast<float>(s.first.x()), last = static_cast<float>(s.last.x());
  for (const auto& p : s.planes) {
    const float at = p[1] * y + p[2] * z + p[3] + p[0] * 3.5F, slope = p[0] * kBrickEdge;
    if (slope > 1e-6F)
      first = std::max(first, -at / slope);
    else if (slope < -1e-6F)
      last = std::min(last, -at / slope);
    else if (at < 0)
      last = first - 1;
    if (!(last >= first - 1)) return {0, -1};
  }
  return {static_cast<int>(std::ceil(first - 1e-3F)), static_cast<int>(std::floor(last + 1e-3F))};
}

/// The sweep over the bricks of a view.
class BrickSweep {
 public:
  BrickSweep(const Sweep& sweep, VoxelMap& map) : s_(sweep), map_(map), offsets_(sweep.forms) {
    for (int i = 0; i < kBoxes; ++i) {
      place(row_, i, kBrickEdge * static_cast<float>(i), 0, 0);
      place(cubes_, i, i & 1 ? 2 : -2, i & 2 ? 2 : -2, i & 4 ? 2 : -2);
    }
    const auto back = [](const float* f) { return -1.5F * (f[0] + f[1] + f[2]); };
    to_corner_ = {back(s_.forms.u), back(s_.forms.v), back(s_.forms.z)};
    set_extent(row_, 3.5F);
    set_extent(cubes_, 1.5F);
  }

  IntegrationStats run() {
    for (int z = s_.first.z(); z <= s_.last.z(); ++z) {
      enter_layer(z);
      for (int y = s_.first.y(); y <= s_.last.y(); ++y) see_row(y, z);
    }
    // What is marked beyond all that the view says something else about.
    for (const std::uint32_t number : s_.marks->bricks()) {
      if (!s_.marks->any(number)) continue;
      const Eigen::Vector3i at = marked_brick(number);
      enter_layer(at.z());
      const std::size_t brick = map_.brick_index(at);
      BrickChange change;
      for (int cube = 0; cube < kBoxes; ++cube)
        hit_marks(at, cube, number, map_.edit(brick).data(), map_.emptied(brick), change);
      finish(brick, change);
    }
    return stats_;
  }

 private:
  /// Voxels from the common place.
  void place(Boxes& boxes, int box, float x, float y, float z) const {
    const auto along = [&](const float* f) { return f[0] * x + f[1] * y + f[2] * z; };
    boxes.u[box] = along(s_.forms.u);
    boxes.v[box] = along(s_.forms.v);
    boxes.z[box] = along(s_.forms.z);
  }
  /// How far boxes reach: `half` voxels along each axis from their middles to the last voxels'.
  void set_extent(Boxes& boxes, float half) const {
    const CameraForms& f = s_.forms;
    const auto along = [&](const float* form, float slope) {
      float sum = 0;
      for (int k = 0; k < 3; ++k) sum += std::abs(form[k] - slope * f.z[k]);
      return half * sum;
    };
    boxes.half = {along(f.u, 0), along(f.v, 0), along(f.z, 0)};
    boxes.reach = {along(f.u, s_.slopes.left), along(f.u, s_.slopes.right), along(f.v, s_.slopes.top),
                   along(f.v, s_.slopes.bottom)};
  }

  void enter_layer(int z) {
    for (int half = 0; half < 2; ++half) foot_[half] = foot_masks(map_, kBrickEdge * z + 4 * half);
  }

  HWY_INLINE void see_row(int y, int z) {
    constexpr float kMiddle = 3.5F;  // voxels from a brick's first
    const float middle_y = static_cast<float>(kBrickEdge * y) + kMiddle,
                middle_z = static_cast<float>(kBrickEdge * z) + kMiddle;
    const Span span = bricks_of_row(s_, middle_y, middle_z);
    for (int x = span.first; x <= span.last; x += kBoxes) {
      const float middle_x = static_cast<float>(kBrickEdge * x) + kMiddle;
      const auto form = [&](const float* f) {
        return f[0] * middle_x + f[1] * middle_y + f[2] * middle_z + f[3];
      };
      const Place first{form(s_.forms.u), form(s_.forms.v), form(s_.forms.z)};
      const BoxClasses classes = classify(s_, first, row_);
      const int count = std::min(kBoxes, span.last - x + 1);
      for (unsigned left = classes.alive & ((1U << count) - 1); left != 0; left &= left - 1) {
        const int i = std::countr_zero(left);
        see_brick({x + i, y, z}, classes.empty() >> i & 1, row_.middle(first, i));
      }
    }
  }

  HWY_INLINE void see_brick(const Eigen::Vector3i& at, bool empty, const Place& middle) {
    const std::size_t number = mark_number(at), brick = map_.brick_index(at);
    const bool marked = s_.marks->any(number);
    LogOdds* values = map_.edit(brick).data();
    std::uint8_t& emptied = map_.emptied(brick);
    BrickChange change;
    if (empty && !marked) {
      for (int cube = 0; cube < kBoxes; ++cube) empty_whole(at, cube, values, emptied, change);
    } else {
      see_cubes(at, middle, marked, number, values, emptied, change);
    }
    finish(brick, change);
  }

  HWY_INLINE void see_cubes(const Eigen::Vector3i& at, const Place& middle, bool marked, std::size_t number,
                            LogOdds* values, std::uint8_t& emptied, BrickChange& change) {
    for (int i = 0; i < kBoxes; ++i) hwy::Prefetch(values + kCubeVoxels * i);
    const Place corner{middle.u + to_corner_.u, middle.v + to_corner_.v, middle.z + to_corner_.z};
    const BoxClasses classes = classify(s_, middle, cubes_);
    for (unsigned left = classes.alive; left != 0; left &= left - 1) {
      const int cube = std::countr_zero(left);
      const std::uint64_t marks = marked ? s_.marks->word(number, cube) : 0;
      if ((classes.empty() >> cube & 1) && marks == 0) {
        empty_whole(at, cube, values, emptied, change);
        continue;
      }
      const Place first = cubes_.middle(corner, cube);
      LogOdds* of_cube = values + kCubeVoxels * cube;
      const CubeBits bits = classes.inside >> cube & 1
                                ? see_cube<true>(s_, offsets_, first, marks, of_cube, change)
                            : (classes.clear >> cube & 1) && marks == 0
                                ? empty_seen(s_, offsets_, first, of_cube, change)
                                : see_cube<false>(s_, offsets_, first, marks, of_cube, change);
      if (bits.hits != 0) emptied &= static_cast<std::uint8_t>(~(1U << cube));
      tell(at, cube, bits);
    }
    if (!marked) return;
    for (int cube = 0; cube < kBoxes; ++cube)
      if (!(classes.alive >> cube & 1)) hit_marks(at, cube, number, values, emptied, change);
    s_.marks->clear(number);
  }

  HWY_INLINE void empty_whole(const Eigen::Vector3i& at, int cube, LogOdds* values, std::uint8_t& emptied,
                              BrickChange& change) {
    tell(at, cube, {0, ~std::uint64_t{0}});
    if (emptied >> cube & 1) return;
    BrickChange of_cube;
    empty_cube(s_, values + kCubeVoxels * cube, of_cube);
    // What a miss leaves as it is, the next one will, too.
    if (!of_cube.changed) emptied |= static_cast<std::uint8_t>(1U << cube);
    change.add(of_cube);
  }

  HWY_INLINE void hit_marks(const Eigen::Vector3i& at, int cube, std::size_t number, LogOdds* values,
                            std::uint8_t& emptied, BrickChange& change) {
    const std::uint64_t marks = s_.marks->word(number, cube);
    if (marks == 0) return;
    hit_marked(s_, values + kCubeVoxels * cube, marks, change);
    emptied &= static_cast<std::uint8_t>(~(1U << cube));
    tell(at, cube, {marks, 0});
  }

  HWY_INLINE void tell(const Eigen::Vector3i& at, int cube, const CubeBits& bits) {
    stats_.hits += static_cast<std::size_t>(std::popcount(bits.hits));
    stats_.misses += static_cast<std::size_t>(std::popcount(bits.misses));
    const FootMasks& m = foot_[cube >> 2];
    const std::uint64_t seen = (m.foot & (bits.hits | bits.misses)) | (m.obstacle & bits.hits);
    if (seen != 0) map_.see_columns(at, cube & 3, columns_of_cube(seen), s_.stamp);
  }

  HWY_INLINE void finish(std::size_t brick, const BrickChange& change) {
    if (!change.changed) return;
    map_.count_change(brick, change.unseen, change.occupied, s_.stamp);
    stats_.first_seen += static_cast<std::size_t>(-change.unseen);
    ++stats_.bricks_changed;
  }

  // Marks are kept by place in the window.
  std::size_t mark_number(const Eigen::Vector3i& at) const {
    const Eigen::Vector3i& n = map_.bricks();
    return static_cast<std::size_t>((at.z() * n.y() + at.y()) * n.x() + at.x());
  }
  Eigen::Vector3i marked_brick(std::uint32_t number) const {
    const int n = static_cast<int>(number), nx = map_.bricks().x(), ny = map_.bricks().y();
    return {n % nx, n / nx % ny, n / (nx * ny)};
  }

  const Sweep& s_;
  VoxelMap& map_;
  const VoxelOffsets offsets_;
  Boxes row_, cubes_;  // the bricks of a row from the first, the cubes of a brick from its middle
  Place to_corner_;    // from a cube's middle to its first voxel's
  FootMasks foot_[2];  // of the lower and the upper cubes of the layer in hand
  IntegrationStats stats_;
};

IntegrationStats sweep_bricks(const Sweep& s, VoxelMap& map) { return BrickSweep(s, map).run(); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::nav
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(sweep_bricks);

FootMasks foot_masks(const VoxelMap& map, int first_layer) {
  FootMasks masks;
  for (int z = 0; z < 4; ++z) {
    const int layer = first_layer + z;
    const std::uint64_t voxels = std::uint64_t{0xffff} << (16 * z);
    if (layer >= map.foot_begin() && layer < map.foot_end()) masks.foot |= voxels;
    if (layer >= map.foot_end() && map.centre({0, 0, layer}).z() <= map.config().obstacle_height)
      masks.obstacle |= voxels;
  }
  return masks;
}

/// The inclusive box of bricks that may lie in the view.
void bound(Sweep& s, const RangeSamples& samples, const VoxelMap& map,
           const Eigen::Isometry3d& map_from_camera) {
  Eigen::Vector3d low = map_from_camera.translation(), high = low;
  const auto z = static_cast<double>(samples.farthest());
  for (const float u : {-0.5F, samples.end_u()}) {
    for (const float v : {-0.5F, samples.end_v()}) {
      const auto x = static_cast<double>((u - samples.cx()) / samples.focal());
      const auto y = static_cast<double>((v - samples.cy()) / samples.focal());
      const Eigen::Vector3d corner = map_from_camera * Eigen::Vector3d(x * z, y * z, z);
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const double brick = map.resolution() * kBrickEdge;
  const Eigen::Array3d end = map.bricks().cast<double>();
  const auto brick_of = [&](const Eigen::Vector3d& p) -> Eigen::Array3i {
    return ((p - map.lowest()).array() / brick).floor().max(-1).min(end).cast<int>();
  };
  s.first = brick_of(low).max(0);
  s.last = brick_of(high).min(map.bricks().array() - 1);
}

/// The view's six sides, moved out by half a brick.
void set_planes(Sweep& s) {
  const CameraForms& f = s.forms;
  for (int j = 0; j < 4; ++j) {
    s.planes[0][j] = f.z[j];
    s.planes[1][j] = -f.z[j];
    s.planes[2][j] = f.u[j] - s.slopes.left * f.z[j];
    s.planes[3][j] = s.slopes.right * f.z[j] - f.u[j];
    s.planes[4][j] = f.v[j] - s.slopes.top * f.z[j];
    s.planes[5][j] = s.slopes.bottom * f.z[j] - f.v[j];
  }
  s.planes[0][3] -= s.near;
  s.planes[1][3] += s.far;
  for (auto& p : s.planes) p[3] += 4.0F * (std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]));
}

CameraForms camera_forms(const RangeSamples& samples, const VoxelMap& map,
                         const Eigen::Isometry3d& map_from_camera) {
  const Eigen::Isometry3d camera_from_map = map_from_camera.inverse();
  const Eigen::Vector3d origin = camera_from_map * map.centre({0, 0, 0});
  const Eigen::Matrix3d step = camera_from_map.linear() * map.resolution();
  const auto steps = static_cast<double>(samples.steps_per_metre());
  const double pixels = steps * static_cast<double>(samples.focal());
  CameraForms f{};
  for (int j = 0; j < 4; ++j) {
    const Eigen::Vector3d c = j < 3 ? Eigen::Vector3d(step.col(j)) : origin;
    f.u[j] = static_cast<float>(c.x() * pixels);
    f.v[j] = static_cast<float>(c.y() * pixels);
    f.z[j] = static_cast<float>(c.z() * steps);
  }
  return f;
}

}  // namespace

void update_bricks(const SeenSpace& seen, Time stamp, VoxelMap& map, IntegrationStats& stats) {
  const RangeSamples& samples = seen.samples;
  Sweep s{};
  s.forms = camera_forms(samples, map, seen.map_from_camera);
  s.cx = samples.cx();
  s.cy = samples.cy();
  s.end_u = samples.end_u();
  s.end_v = samples.end_v();
  s.slopes = {-0.5F - s.cx, s.end_u - s.cx, -0.5F - s.cy, s.end_v - s.cy};
  s.near = samples.near() * samples.steps_per_metre();
  s.far = samples.farthest() * samples.steps_per_metre();
  s.half_voxel = static_cast<float>(map.resolution() / 2) * samples.focal() * samples.steps_per_metre();
  s.width = samples.words().width();
  s.height = samples.words().height();
  s.words = samples.words().data();
  s.stride = static_cast<std::int32_t>(samples.words().stride());
  s.bounds = &samples.bounds();
  s.classes = &seen.classes;
  s.marks = &seen.marks;
  s.least_hit = seen.least_hit;
  s.least_before_hit = seen.least_before_hit;
  s.wide = log_odds::kHit - seen.classes.short_of_hit[samples.widest()] < seen.least_hit;
  s.stamp = stamp;
  bound(s, samples, map, seen.map_from_camera);
  set_planes(s);
  const IntegrationStats done = HWY_DYNAMIC_DISPATCH(sweep_bricks)(s, map);
  stats.hits = done.hits;
  stats.misses = done.misses;
  stats.first_seen = done.first_seen;
  stats.bricks_changed = done.bricks_changed;
}

}  // namespace headway::nav
#endif
