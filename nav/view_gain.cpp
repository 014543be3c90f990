#include "nav/view_gain.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "hal/error.h"
#include "nav/solid_boxes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/view_gain.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace headway::nav {

#ifndef HEADWAY_GAIN_TASK
#define HEADWAY_GAIN_TASK
namespace {

/// A brick whose voxels must be looked at one by one. Lengths in voxels, camera frame.
struct GainTask {
  const LogOdds* values;
  int first_layer, end_layer;
  // The centre of voxel (0, 0, 0), and the way to the next along each axis.
  Eigen::Vector3f first, dx, dy, dz;
  std::span<const Eigen::Vector4f> rows;
  const RayImage& rays;
  ReachBounds reach;  // of the rays that meet the brick
};

}  // namespace
#endif

namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, VoxelMap::kBrickEdge>;
using V = hn::Vec<Tag>;

/// n p + d at the voxels' centres p.
struct Slope {
  float at_first, dx, dy, dz;

  Slope(const GainTask& t, const Eigen::Vector3f& n, float d)
      : at_first(n.dot(t.first) + d), dx(n.dot(t.dx)), dy(n.dot(t.dy)), dz(n.dot(t.dz)) {}
  float at(int x, int y, int z) const {
    return at_first + static_cast<float>(x) * dx + static_cast<float>(y) * dy + static_cast<float>(z) * dz;
  }
};

/// A bit for each voxel that may count, and one for each whose ray must be asked. A vector's lanes are the
/// lowest bits of a byte; a row of a brick takes as many bytes as it takes vectors.
struct Marks {
  std::uint8_t may_count[VoxelMap::kBrickVoxels], ask_ray[VoxelMap::kBrickVoxels];
};

/// Visits the vectors of all rows: the number of their byte, and where they begin in the brick.
template <class Visit>
HWY_INLINE void for_each_vector(const GainTask& t, const Visit& visit) {
  constexpr int kEdge = VoxelMap::kBrickEdge;
  const int lanes = static_cast<int>(hn::Lanes(Tag()));
  std::size_t byte = 0;
  for (int z = t.first_layer; z < t.end_layer; ++z)
    for (int y = 0; y < kEdge; ++y)
      for (int x = 0; x < kEdge; x += lanes) visit(byte++, x, y, z);
}

/// A slope's values at the voxels of a vector.
class Values {
 public:
  explicit HWY_INLINE Values(const Slope& slope)
      : slope_(slope), along_(hn::Mul(hn::Iota(Tag(), 0), hn::Set(Tag(), slope.dx))) {}
  HWY_INLINE V operator()(int x, int y, int z) const {
    return hn::Add(along_, hn::Set(Tag(), slope_.at(x, y, z)));
  }

 private:
  Slope slope_;
  V along_;  ///< Iota goes by way of memory: made for each vector, it would stall
};

HWY_INLINE std::uint8_t bits_of(hn::Mask<Tag> mask) {
  std::uint8_t stored[8] = {};
  hn::StoreMaskBits(Tag(), mask, stored);
  return stored[0];
}

HWY_INLINE void mark_unseen(const GainTask& t, Marks& marks) {
  const Tag d;
  const hn::Rebind<std::int8_t, Tag> d8;
  const hn::Rebind<std::int32_t, Tag> whole;
  const auto unseen = hn::Set(whole, log_odds::kUnseen);
  std::int8_t row[VoxelMap::kBrickEdge];
  for_each_vector(t, [&](std::size_t byte, int x, int y, int z) HWY_ATTR {
    // However bricks are ordered, four voxels along x stand side by side.
    if (x == 0) {
      std::memcpy(row, t.values + VoxelMap::in_brick(0, y, z), 4);
      std::memcpy(row + 4, t.values + VoxelMap::in_brick(4, y, z), 4);
    }
    const auto values = hn::PromoteTo(whole, hn::LoadU(d8, row + x));
    marks.may_count[byte] = bits_of(hn::RebindMask(d, hn::Eq(values, unseen)));
  });
}

HWY_INLINE hn::Mask<Tag> in_front(const GainTask& t, const V& x, const V& y, const V& z) {
  const Tag d;
  const hn::Rebind<std::int32_t, Tag> whole;
  const RayGrid& g = t.rays.grid();
  const V inverse = hn::Div(hn::Set(d, 1 / g.step), hn::Max(z, hn::Set(d, 1e-3F)));
  const auto cell = [&](const V& a, float first, int count) HWY_ATTR {
    const V at = hn::MulSub(a, inverse, hn::Set(d, first / g.step));
    return hn::ConvertTo(whole, hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, static_cast<float>(count - 1))));
  };
  const auto u = cell(x, g.x0, g.width), v = cell(y, g.y0, g.height);
  const auto at = hn::Add(hn::Mul(v, hn::Set(whole, t.rays.stride())), u);
  return hn::Lt(z, hn::GatherIndex(d, t.rays.reach().data(), at));
}

std::size_t count_voxels(const GainTask& t) {
  const Tag d;
  Marks marks;
  mark_unseen(t, marks);
  // Within the field.
  for (const Eigen::Vector4f& row : t.rows) {
    const Values side(Slope(t, row.head<3>(), row.w()));
    for_each_vector(t, [&](std::size_t byte, int x, int y, int z) HWY_ATTR {
      marks.may_count[byte] &= bits_of(hn::Ge(side(x, y, z), hn::Zero(d)));
    });
  }
  // Behind the end of all rays that meet the brick, or before the end of all of them: no ray need be asked.
  const V least = hn::Set(d, t.reach.least), most = hn::Set(d, t.reach.most);
  const Values right(Slope(t, Eigen::Vector3f::UnitX(), 0)), down(Slope(t, Eigen::Vector3f::UnitY(), 0)),
      ahead(Slope(t, Eigen::Vector3f::UnitZ(), 0));
  for_each_vector(t, [&](std::size_t byte, int x, int y, int z) HWY_ATTR {
    const V depth = ahead(x, y, z);
    marks.may_count[byte] &= bits_of(hn::Lt(depth, most));
    marks.ask_ray[byte] = marks.may_count[byte] & bits_of(hn::Ge(depth, least));
  });
  std::size_t found = 0;
  for_each_vector(t, [&](std::size_t byte, int x, int y, int z) HWY_ATTR {
    if (marks.ask_ray[byte] != 0)
      marks.may_count[byte] &= bits_of(in_front(t, right(x, y, z), down(x, y, z), ahead(x, y, z)));
    found += static_cast<std::size_t>(std::popcount(marks.may_count[byte]));
  });
  return found;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::nav
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace headway::nav {

HWY_EXPORT(count_voxels);

namespace {

constexpr int kEdge = VoxelMap::kBrickEdge;
constexpr float kHalfBrick = 0.5F * kEdge;

// One ray per voxel's width at the far end of the field, but no more than a camera has pixels.
RayGrid grid_for(const vision::Polytope& field, double resolution) {
  if (field.corners.empty() || !field.directions.empty())
    throw InputError("view gain: field: has no end, expected one with a farthest depth");
  if (!(resolution > 0)) throw InputError("view gain: resolution: is not positive");
  double far = 0;
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Eigen::Vector3d& corner : field.corners) {
    if (!(corner.z() > 0))
      throw InputError("view gain: field: reaches to the camera or behind it, expected a nearest depth");
    far = std::max(far, corner.z());
    low = low.min(corner.head<2>().array() / corner.z());
    high = high.max(corner.head<2>().array() / corner.z());
  }
  constexpr double kMostRays = 640;
  const double step = std::max(resolution / far, (high - low).maxCoeff() / kMostRays);
  const Eigen::Array2d size = ((high - low) / step).ceil().max(1);
  return {static_cast<int>(size.x()), static_cast<int>(size.y()), static_cast<float>(low.x()),
          static_cast<float>(low.y()), static_cast<float>(step)};
}

Eigen::Vector4f in_voxels(const Eigen::Vector4d& row, double resolution) {
  Eigen::Vector4d scaled = row;
  scaled.w() /= resolution;
  return scaled.cast<float>();
}

}  // namespace

/// The camera among the voxels: lengths in voxels, the map's origin at the corner of voxel (0, 0, 0).
struct ViewGain::Look {
  Eigen::Isometry3d voxels_from_camera;
  Eigen::Matrix3f camera_from_map;  ///< turns; its columns are one voxel along each axis
  Eigen::Matrix3f extent;           ///< of absolute values
  Eigen::Vector3f half_brick;       ///< how far a brick reaches along the camera's axes

  Look(const VoxelMap& map, const Eigen::Isometry3d& map_from_camera) : voxels_from_camera(map_from_camera) {
    voxels_from_camera.translation() =
        map_from_camera.translation() / map.resolution() - map.first_key().cast<double>();
    camera_from_map = map_from_camera.linear().transpose().cast<float>();
    extent = camera_from_map.cwiseAbs();
    half_brick = extent * Eigen::Vector3f::Constant(kHalfBrick);
  }
  /// A place among the voxels as seen from the camera, along the map's axes.
  Eigen::Vector3f from_eye(const Eigen::Vector3i& voxel) const {
    return (voxel.cast<double>() - voxels_from_camera.translation()).cast<float>();
  }
};

/// Bricks [first, end).
struct ViewGain::BrickBox {
  Eigen::Vector3i first, end;
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (int z = first.z(); z < end.z(); ++z)
      for (int y = first.y(); y < end.y(); ++y)
        for (int x = first.x(); x < end.x(); ++x) visit(Eigen::Vector3i(x, y, z));
  }
};

ViewGain::ViewGain(const vision::Polytope& field, double resolution, const UsefulSpace& space)
    : field_(field), space_(space), rays_(grid_for(field, resolution)) {
  if (!(space.lowest < space.highest))
    throw InputError("view gain: lowest: is not below highest, expected a space with some height");
}

std::size_t ViewGain::gain(const VoxelMap& map, const Eigen::Isometry3d& map_from_camera,
                           std::span<const Eigen::Isometry3d> looked) {
  const Look look(map, map_from_camera);
  rows_.clear();
  for (const Eigen::Vector4d& row : field_.rows) rows_.push_back(in_voxels(row, map.resolution()));
  const BrickBox box = bricks_around(map, look);
  rays_.begin(map_from_camera.linear().cast<float>());
  end_rays_in(looked, map, map_from_camera);
  end_rays_at_obstacles(map, look, box);
  rays_.settle();
  return count(map, look, box);
}

ViewGain::BrickBox ViewGain::bricks_around(const VoxelMap& map, const Look& look) const {
  Eigen::Vector3d low = look.voxels_from_camera.translation(), high = low;
  for (const Eigen::Vector3d& corner : field_.corners) {
    const Eigen::Vector3d at = look.voxels_from_camera * Eigen::Vector3d(corner / map.resolution());
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const Eigen::Array3d end = map.bricks().cast<double>();
  const auto brick = [&](const Eigen::Vector3d& p) -> Eigen::Vector3i {
    return (p.array() / kEdge).floor().max(-1).min(end).cast<int>().matrix();
  };
  return {brick(low).cwiseMax(0), (brick(high).array() + 1).min(map.bricks().array()).matrix()};
}

void ViewGain::end_rays_in(std::span<const Eigen::Isometry3d> looked, const VoxelMap& map,
                           const Eigen::Isometry3d& map_from_camera) {
  std::vector<Eigen::Vector4f> rows(field_.rows.size());
  for (const Eigen::Isometry3d& earlier : looked) {
    const Eigen::Matrix4d earlier_from_camera = (earlier.inverse() * map_from_camera).matrix();
    for (std::size_t i = 0; i < rows.size(); ++i)
      rows[i] = in_voxels(earlier_from_camera.transpose() * field_.rows[i], map.resolution());
    rays_.end_inside(rows);
  }
}

void ViewGain::end_rays_at_obstacles(const VoxelMap& map, const Look& look, const BrickBox& box) {
  box.for_each([&](const Eigen::Vector3i& at) {
    const std::size_t brick = map.brick_index(at);
    if (map.summary(brick).occupied == 0) return;
    const Eigen::Vector3f corner = look.from_eye(kEdge * at);
    const Eigen::Vector3f centre = look.camera_from_map * (corner + Eigen::Vector3f::Constant(kHalfBrick));
    if (rays_.rect(centre, look.half_brick).empty()) return;
    for (const SolidBox8& solid : SolidBoxes(map.values(brick))) {
      const Eigen::Vector3f low = corner + Eigen::Vector3f(solid.low[0], solid.low[1], solid.low[2]);
      const Eigen::Vector3f high = corner + Eigen::Vector3f(solid.high[0], solid.high[1], solid.high[2]);
      const RayRect rect =
          rays_.rect(look.camera_from_map * ((low + high) / 2), look.extent * ((high - low) / 2));
      if (!rect.empty()) rays_.end_at_box(low, high, rect);
    }
  });
}

std::size_t ViewGain::count(const VoxelMap& map, const Look& look, const BrickBox& box) {
  std::size_t found = 0;
  for (int z = box.first.z(); z < box.end.z(); ++z) {
    const auto useful = [&](int layer) {
      const double height = map.centre({0, 0, layer}).z();
      return height >= space_.lowest && height <= space_.highest;
    };
    int first = 0, end = kEdge;
    while (first < kEdge && !useful(kEdge * z + first)) ++first;
    while (end > first && !useful(kEdge * z + end - 1)) --end;
    if (first == end) continue;
    BrickBox layer = box;
    layer.first.z() = z;
    layer.end.z() = z + 1;
    layer.for_each([&](const Eigen::Vector3i& at) { found += count_in(map, look, at, first, end); });
  }
  return found;
}

std::size_t ViewGain::count_in(const VoxelMap& map, const Look& look, const Eigen::Vector3i& at,
                               int first_layer, int end_layer) {
  const std::size_t brick = map.brick_index(at);
  const std::size_t unseen = map.summary(brick).unseen;
  if (unseen == 0) return 0;
  const Eigen::Vector3f centre =
      look.camera_from_map * (look.from_eye(kEdge * at) + Eigen::Vector3f::Constant(kHalfBrick));
  crossing_.clear();
  for (const Eigen::Vector4f& row : rows_) {
    const float side = row.head<3>().dot(centre) + row.w();
    const float half = (row.head<3>().transpose() * look.camera_from_map).cwiseAbs().sum() * kHalfBrick;
    if (side < -half) return 0;
    if (side < half) crossing_.push_back(row);
  }
  const RayRect rect = rays_.rect(centre, look.half_brick);
  if (rect.empty()) return 0;
  const ReachBounds reach = rays_.bounds(rect);
  if (centre.z() - look.half_brick.z() >= reach.most) return 0;
  if (crossing_.empty() && centre.z() + look.half_brick.z() < reach.least && end_layer - first_layer == kEdge)
    return unseen;
  const Eigen::Vector3f first =
      look.camera_from_map * (look.from_eye(kEdge * at) + Eigen::Vector3f::Constant(0.5F));
  return HWY_DYNAMIC_DISPATCH(count_voxels)({map.values(brick).data(), first_layer, end_layer, first,
                                             look.camera_from_map.col(0), look.camera_from_map.col(1),
                                             look.camera_from_map.col(2), crossing_, rays_, reach});
}

}  // namespace headway::nav

#endif  // HWY_ONCE
