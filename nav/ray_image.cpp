#include "nav/ray_image.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/ray_image.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace headway::nav {

#ifndef HEADWAY_RAY_TASKS
#define HEADWAY_RAY_TASKS
namespace {

constexpr int kMostLanes = 16;        // more than any instruction set has for floats
constexpr float kLeastSlope = 1e-9F;  // so that no inverse is infinite

struct DirectionTask {
  RayGrid grid;
  int stride;
  const Eigen::Matrix3f& map_from_camera;
  float* inverse[3];
};

/// A box of which no side passes the eye: along each axis of the map, a ray that meets it goes first through
/// the plane that is nearer to the eye.
struct BoxTask {
  const float *inverse_x, *inverse_y, *inverse_z;
  float* reach;
  int stride;
  RayRect rect;
  Eigen::Vector3f near, far;
};

struct InsideTask {
  RayGrid grid;
  float* reach;
  int stride;
  std::span<const Eigen::Vector4f> rows;
};

}  // namespace
#endif

namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kMostLanes>;
using V = hn::Vec<Tag>;

// One over the rays' directions along the map's axes.
void invert_directions(const DirectionTask& t) {
  const Tag d;
  const V one = hn::Set(d, 1), least = hn::Set(d, kLeastSlope), lane = hn::Iota(d, 0);
  const int lanes = static_cast<int>(hn::Lanes(d));
  const RayGrid& g = t.grid;
  for (int v = 0; v < g.height; ++v) {
    const Eigen::Vector3f first =
        t.map_from_camera *
        Eigen::Vector3f(g.x0 + 0.5F * g.step, g.y0 + (static_cast<float>(v) + 0.5F) * g.step, 1);
    for (int k = 0; k < 3; ++k) {
      float* row = t.inverse[k] + static_cast<std::ptrdiff_t>(v) * t.stride;
      const V start = hn::Set(d, first[k]), step = hn::Set(d, g.step * t.map_from_camera(k, 0));
      for (int u = 0; u < t.stride; u += lanes) {
        const V slope = hn::MulAdd(hn::Add(lane, hn::Set(d, static_cast<float>(u))), step, start);
        const auto level = hn::Lt(hn::Abs(slope), least);
        hn::StoreU(hn::Div(one, hn::IfThenElse(level, hn::CopySign(least, slope), slope)), d, row + u);
      }
    }
  }
}

// Where rays enter and leave the box between three pairs of planes.
void end_at_box(const BoxTask& t) {
  const Tag d;
  const V never = hn::Set(d, std::numeric_limits<float>::infinity()), zero = hn::Zero(d);
  const V x0 = hn::Set(d, t.near.x()), y0 = hn::Set(d, t.near.y()), z0 = hn::Set(d, t.near.z());
  const V x1 = hn::Set(d, t.far.x()), y1 = hn::Set(d, t.far.y()), z1 = hn::Set(d, t.far.z());
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int v = t.rect.v0; v < t.rect.v1; ++v) {
    for (int u = t.rect.u0; u < t.rect.u1; u += lanes) {
      const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(v) * t.stride + u;
      const V ix = hn::LoadU(d, t.inverse_x + i), iy = hn::LoadU(d, t.inverse_y + i),
              iz = hn::LoadU(d, t.inverse_z + i);
      const V in = hn::Max(hn::Max(hn::Mul(x0, ix), hn::Mul(y0, iy)), hn::Mul(z0, iz));
      const V out = hn::Min(hn::Min(hn::Mul(x1, ix), hn::Mul(y1, iy)), hn::Mul(z1, iz));
      const auto meets = hn::And(hn::Le(in, out), hn::Gt(out, zero));
      const V end = hn::IfThenElse(meets, hn::Max(in, zero), never);
      hn::StoreU(hn::Min(hn::LoadU(d, t.reach + i), end), d, t.reach + i);
    }
  }
}

// The stretch of each ray that lies on the good side of every plane. A ray stands for all of its pixel: it is
// within as soon as a corner of that is.
void end_inside(const InsideTask& t) {
  const Tag d;
  const V never = hn::Set(d, std::numeric_limits<float>::infinity()), zero = hn::Zero(d);
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V first =
      hn::MulAdd(hn::Add(hn::Iota(d, 0), hn::Set(d, 0.5F)), hn::Set(d, t.grid.step), hn::Set(d, t.grid.x0));
  for (int v = 0; v < t.grid.height; ++v) {
    const float y = t.grid.y0 + (static_cast<float>(v) + 0.5F) * t.grid.step;
    for (int u = 0; u < t.grid.width; u += lanes) {
      const V x = hn::Add(first, hn::Set(d, static_cast<float>(u) * t.grid.step));
      V in = zero, out = never;
      for (const Eigen::Vector4f& row : t.rows) {
        const float corner = 0.5F * t.grid.step * (std::abs(row.x()) + std::abs(row.y()));
        const V slope = hn::MulAdd(x, hn::Set(d, row.x()), hn::Set(d, row.y() * y + row.z() + corner));
        const V at = hn::Div(hn::Set(d, -row.w()), slope);
        in = hn::IfThenElse(hn::Gt(slope, zero), hn::Max(in, at), in);
        out = hn::IfThenElse(hn::Lt(slope, zero), hn::Min(out, at), out);
      }
      float* reach = t.reach + static_cast<std::ptrdiff_t>(v) * t.stride + u;
      const V end = hn::IfThenElse(hn::Lt(in, out), in, never);
      hn::StoreU(hn::Min(hn::LoadU(d, reach), end), d, reach);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::nav
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace headway::nav {

HWY_EXPORT(invert_directions);
HWY_EXPORT(end_at_box);
HWY_EXPORT(end_inside);

namespace {

constexpr int kTile = 8;               // rays
constexpr float kAtTheCamera = 1e-3F;  // nearer than this a box's outline is not worked out

}  // namespace

RayImage::RayImage(const RayGrid& grid)
    : grid_(grid),
      stride_((grid.width + 2 * kMostLanes - 1) / kMostLanes * kMostLanes),
      tiles_across_((grid.width + kTile - 1) / kTile),
      tiles_down_((grid.height + kTile - 1) / kTile) {
  const std::size_t rays = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(grid.height);
  for (auto* values : {&inverse_x_, &inverse_y_, &inverse_z_, &reach_}) values->assign(rays, 0);
  tiles_.resize(static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(tiles_down_));
}

void RayImage::begin(const Eigen::Matrix3f& map_from_camera) {
  HWY_DYNAMIC_DISPATCH(invert_directions)
  ({grid_, stride_, map_from_camera, {inverse_x_.data(), inverse_y_.data(), inverse_z_.data()}});
  std::fill(reach_.begin(), reach_.end(), std::numeric_limits<float>::infinity());
}

void RayImage::end_inside(std::span<const Eigen::Vector4f> rows) {
  HWY_DYNAMIC_DISPATCH(end_inside)({grid_, reach_.data(), stride_, rows});
}

void RayImage::end_at_box(const Eigen::Vector3f& low, const Eigen::Vector3f& high, const RayRect& rect) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(low[axis] < 0 && high[axis] > 0)) continue;
    // On both sides of the eye: two boxes that meet there.
    Eigen::Vector3f end_of_low = high, start_of_high = low;
    end_of_low[axis] = start_of_high[axis] = 0;
    end_at_box(low, end_of_low, rect);
    end_at_box(start_of_high, high, rect);
    return;
  }
  const Eigen::Vector3f near = (low.array() >= 0).select(low.array(), high.array()).matrix(),
                        far = (low.array() >= 0).select(high.array(), low.array()).matrix();
  HWY_DYNAMIC_DISPATCH(end_at_box)
  ({inverse_x_.data(), inverse_y_.data(), inverse_z_.data(), reach_.data(), stride_, rect, near, far});
}

void RayImage::settle() {
  std::fill(tiles_.begin(), tiles_.end(), ReachBounds{std::numeric_limits<float>::infinity(), 0});
  for (int v = 0; v < grid_.height; ++v) {
    const float* row = reach_.data() + static_cast<std::ptrdiff_t>(v) * stride_;
    ReachBounds* tiles = tiles_.data() + static_cast<std::ptrdiff_t>(v / kTile) * tiles_across_;
    for (int u = 0; u < grid_.width; ++u) {
      ReachBounds& tile = tiles[u / kTile];
      tile.least = std::min(tile.least, row[u]);
      tile.most = std::max(tile.most, row[u]);
    }
  }
}

RayRect RayImage::rect(const Eigen::Vector3f& centre, const Eigen::Vector3f& half) const {
  const float near = centre.z() - half.z(), far = centre.z() + half.z();
  if (far <= 0) return {};
  // The extremes of x/z lie at the corners of the box; across the camera only the side planes tell.
  const auto across = [&](float x, float r, float first, int count, int& from, int& to) {
    const float last = first + static_cast<float>(count) * grid_.step;
    if (near <= kAtTheCamera) {
      const bool beside = x - last * centre.z() > r + std::abs(last) * half.z() ||
                          first * centre.z() - x > r + std::abs(first) * half.z();
      from = 0;
      to = beside ? 0 : count;
      return;
    }
    const float low = x - r, high = x + r, size = static_cast<float>(count);
    const float begin = (low / (low < 0 ? near : far) - first) / grid_.step;
    const float end = (high / (high < 0 ? far : near) - first) / grid_.step;
    from = static_cast<int>(std::clamp(std::floor(begin), 0.0F, size));
    to = static_cast<int>(std::clamp(std::floor(end) + 1, 0.0F, size));
  };
  RayRect rect;
  across(centre.x(), half.x(), grid_.x0, grid_.width, rect.u0, rect.u1);
  across(centre.y(), half.y(), grid_.y0, grid_.height, rect.v0, rect.v1);
  return rect;
}

ReachBounds RayImage::bounds(const RayRect& rect) const {
  ReachBounds all{std::numeric_limits<float>::infinity(), 0};
  for (int y = rect.v0 / kTile; y <= (rect.v1 - 1) / kTile; ++y) {
    for (int x = rect.u0 / kTile; x <= (rect.u1 - 1) / kTile; ++x) {
      const ReachBounds& tile = tiles_[static_cast<std::size_t>(y * tiles_across_ + x)];
      all.least = std::min(all.least, tile.least);
      all.most = std::max(all.most, tile.most);
    }
  }
  return all;
}

}  // namespace headway::nav

#endif  // HWY_ONCE
