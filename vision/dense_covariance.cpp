#include "vision/dense_covariance.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/dense_covariance.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "vision/triangulation.h"

// Everything above HWY_ONCE is compiled once for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace headway::vision {

#ifndef HEADWAY_DENSE_TASK
#define HEADWAY_DENSE_TASK
namespace {

enum class Given { kDisparity, kDepth };

/// What the kernels read and write: plain pointers and numbers. `sigma` and `weight` may be null.
struct DenseTask {
  const float *values, *sigma, *weight;
  float focal_baseline, inverse_focal_baseline, inverse_focal, cx, cy;
  float offset, constant_sigma, near, largest_relative_sigma;
  std::size_t width, height;
  float *x, *y, *z, *xx, *xy, *xz, *yy, *yz, *zz, *out_weight;
};

}  // namespace
#endif

namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// The points of pixels i, i + 1, ... (as many as D has lanes, which `lane` numbers), which lie in one row
/// from column u on.
template <Given kGiven, PixelErrors kErrors, class D>
HWY_INLINE void points_at(D d, hn::Vec<D> lane, const DenseTask& t, std::size_t i, float u, float y_over_f) {
  using V = hn::Vec<D>;
  const V none = hn::Set(d, std::numeric_limits<float>::quiet_NaN()), zero = hn::Zero(d);
  const V sigma = t.sigma ? hn::LoadU(d, t.sigma + i) : hn::Set(d, t.constant_sigma);
  const V value = hn::Add(hn::LoadU(d, t.values + i), hn::Set(d, t.offset));
  V z = value, relative;
  if constexpr (kGiven == Given::kDisparity) {
    z = hn::Div(hn::Set(d, t.focal_baseline), value);
    relative = hn::Mul(hn::Mul(z, hn::Set(d, t.inverse_focal_baseline)), sigma);
  } else {
    relative = hn::Div(sigma, z);
  }
  // Also false where anything is NaN.
  const auto measured = hn::And(hn::And(hn::Gt(value, zero), hn::Ge(z, hn::Set(d, t.near))),
                                hn::Le(sigma, hn::Mul(hn::Set(d, t.largest_relative_sigma), value)));
  z = hn::IfThenElse(measured, z, none);  // and with it everything below

  const V z_over_f = hn::Mul(z, hn::Set(d, t.inverse_focal));
  const V x = hn::Mul(hn::Add(lane, hn::Set(d, u - t.cx)), z_over_f);
  const V y = hn::Mul(hn::Set(d, y_over_f), z);
  // Both models are  Sigma = q q^T + h^2 diag(1, 1, 0)  with q along the depth's error and h across: in the
  // paper's the ray midway between the two cameras' pixels errs independently of the disparity.
  V qx = hn::Mul(relative, x), h;
  if constexpr (kErrors == PixelErrors::kPlaceAndDisparity) {
    h = hn::Mul(z_over_f, hn::Set(d, static_cast<float>(RangeView::kPixelSigma)));
  } else {
    h = hn::Mul(z_over_f, hn::Mul(sigma, hn::Set(d, 0.5F)));
    qx = hn::Sub(qx, h);
  }
  const V qy = hn::Mul(relative, y), qz = hn::Mul(relative, z), across = hn::Mul(h, h);
  hn::StoreU(x, d, t.x + i);
  hn::StoreU(y, d, t.y + i);
  hn::StoreU(z, d, t.z + i);
  hn::StoreU(hn::MulAdd(qx, qx, across), d, t.xx + i);
  hn::StoreU(hn::Mul(qx, qy), d, t.xy + i);
  hn::StoreU(hn::Mul(qx, qz), d, t.xz + i);
  hn::StoreU(hn::MulAdd(qy, qy, across), d, t.yy + i);
  hn::StoreU(hn::Mul(qy, qz), d, t.yz + i);
  hn::StoreU(hn::Mul(qz, qz), d, t.zz + i);
  const V weight = t.weight ? hn::LoadU(d, t.weight + i) : hn::Set(d, 1.0F);
  hn::StoreU(hn::IfThenElseZero(measured, weight), d, t.out_weight + i);
}

template <Given kGiven, PixelErrors kErrors>
void all_points(const DenseTask& t) {
  const hn::ScalableTag<float> many;
  const hn::CappedTag<float, 1> one;
  const auto lane = hn::Iota(many, 0);
  const std::size_t lanes = hn::Lanes(many);
  for (std::size_t v = 0; v < t.height; ++v) {
    const float y_over_f = (static_cast<float>(v) - t.cy) * t.inverse_focal;
    std::size_t u = 0, i = v * t.width;
    for (; u + lanes <= t.width; u += lanes, i += lanes)
      points_at<kGiven, kErrors>(many, lane, t, i, static_cast<float>(u), y_over_f);
    for (; u < t.width; ++u, ++i)
      points_at<kGiven, kErrors>(one, hn::Zero(one), t, i, static_cast<float>(u), y_over_f);
  }
}

void from_place_and_disparity(const DenseTask& t) {
  all_points<Given::kDisparity, PixelErrors::kPlaceAndDisparity>(t);
}
void from_four_coordinates(const DenseTask& t) {
  all_points<Given::kDisparity, PixelErrors::kFourCoordinates>(t);
}
void from_depth(const DenseTask& t) { all_points<Given::kDepth, PixelErrors::kPlaceAndDisparity>(t); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {
namespace {

HWY_EXPORT(from_place_and_disparity);
HWY_EXPORT(from_four_coordinates);
HWY_EXPORT(from_depth);

DenseTask task_of(const PinholeCamera& camera, DensePoints& points) {
  DenseTask t{};
  t.inverse_focal = static_cast<float>(1 / camera.focal);
  t.cx = static_cast<float>(camera.cx), t.cy = static_cast<float>(camera.cy);
  t.width = static_cast<std::size_t>(camera.width), t.height = static_cast<std::size_t>(camera.height);
  const auto plane = [&](DensePoints::Plane p) { return points[p].data(); };
  t.x = plane(DensePoints::kX), t.y = plane(DensePoints::kY), t.z = plane(DensePoints::kZ);
  t.xx = plane(DensePoints::kXX), t.xy = plane(DensePoints::kXY), t.xz = plane(DensePoints::kXZ);
  t.yy = plane(DensePoints::kYY), t.yz = plane(DensePoints::kYZ), t.zz = plane(DensePoints::kZZ);
  t.out_weight = plane(DensePoints::kWeight);
  return t;
}

// A plane of another size: nothing can be said of any pixel.
void clear(DensePoints& points) {
  for (int plane = 0; plane < DensePoints::kPlanes; ++plane) {
    const bool weight = plane == DensePoints::kWeight;
    std::ranges::fill(points[DensePoints::Plane(plane)],
                      weight ? 0 : std::numeric_limits<float>::quiet_NaN());
  }
}

bool fits(std::span<const float> plane, const DensePoints& points) {
  return plane.empty() || plane.size() == points.size();
}

}  // namespace

// Where the planes lie is worth a factor of two. A processor takes a load for one that must wait for an
// earlier store when both have the same place in their page; images come from the allocator at the start of a
// page, so the planes begin half a page later, and each a few cache lines after the one before, so that
// writing them side by side does not fill one set of the cache.
void DensePoints::resize(int width, int height) {
  constexpr std::size_t kPage = 4096 / sizeof(float), kApart = 192 / sizeof(float);
  width_ = width, height_ = height;
  size_ = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  stride_ = (size_ + kPage - 1) / kPage * kPage + kApart;
  memory_.resize(kPage + kPlanes * stride_);
  const std::size_t place = reinterpret_cast<std::uintptr_t>(memory_.data()) / sizeof(float) % kPage;
  first_ = (kPage + kPage / 2 - place) % kPage;
}

void dense_points(const DisparityImage& disparity, std::span<const float> weight, const RectifiedRig& rig,
                  PixelErrors errors, DensePoints& points) {
  points.resize(rig.camera.width, rig.camera.height);
  if (disparity.values.size() != points.size() || !fits(disparity.sigma, points) || !fits(weight, points))
    return clear(points);
  DenseTask t = task_of(rig.camera, points);
  t.values = disparity.values.data();
  t.sigma = disparity.sigma.empty() ? nullptr : disparity.sigma.data();
  t.weight = weight.empty() ? nullptr : weight.data();
  t.focal_baseline = static_cast<float>(rig.camera.focal * rig.baseline);
  t.inverse_focal_baseline = static_cast<float>(1 / (rig.camera.focal * rig.baseline));
  t.offset = static_cast<float>(rig.disparity_offset);
  t.constant_sigma = static_cast<float>(rig.disparity_sigma);
  t.near = static_cast<float>(rig.nearest);
  t.largest_relative_sigma = static_cast<float>(kLargestRelativeSigma);
  if (errors == PixelErrors::kFourCoordinates)
    HWY_DYNAMIC_DISPATCH(from_four_coordinates)(t);
  else
    HWY_DYNAMIC_DISPATCH(from_place_and_disparity)(t);
}

void dense_points(const RangeView& view, std::span<const float> weight, DensePoints& points) {
  points.resize(view.camera.width, view.camera.height);
  if (view.depth.size() != points.size() || view.sigma_depth.size() != points.size() || !fits(weight, points))
    return clear(points);
  DenseTask t = task_of(view.camera, points);
  t.values = view.depth.data(), t.sigma = view.sigma_depth.data();
  t.weight = weight.empty() ? nullptr : weight.data();
  t.largest_relative_sigma = std::numeric_limits<float>::infinity();  // the view's points were judged before
  HWY_DYNAMIC_DISPATCH(from_depth)(t);
}

}  // namespace headway::vision
#endif
