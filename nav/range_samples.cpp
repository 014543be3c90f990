#include "nav/range_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "nav/sample_errors.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav/range_samples.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Everything above HWY_ONCE is compiled once for each instruction set. Only exact operations are used (no
// approximate reciprocals, no fused sums), so that all of them give the same bytes.
HWY_BEFORE_NAMESPACE();
namespace headway::nav {

#ifndef HEADWAY_SAMPLE_ROWS
#define HEADWAY_SAMPLE_ROWS
namespace {

constexpr float kMost = 16383;                  // steps of depth
constexpr float kBeyondFar = 1.25F;             // depths are told apart up to so many times the view's far
constexpr float kBeyondCorner = 0.75F;          // samples
constexpr float kFall = 0.15F;                  // samples
constexpr float kKept = 1.1F;                   // of a voxel's thickness is kept from being emptied
constexpr DepthBounds::Word kOutside = 0xffff;  // of the image: says nothing about what lies inside

/// What describing a row of samples needs.
struct DescribeTask {
  const RingImage<float>& w;
  const RingImage<float>& sigma;
  const RingImage<float>& mean_sigma;  // wider where few samples share a mean
  float focal, cx, cy, far, steps_per_metre;
  float half_edge;  // of a voxel [m], somewhat more
  float most_half, resolution, free_sigmas, hit_sigmas;
  int taps;           // samples between a sample and those that its slope is taken from
  const float* turn;  // map from camera, row by row
  const MarkFrame& frame;
  VoxelMarks& marks;
};

struct RowCounts {
  std::size_t used = 0;
  std::uint32_t farthest = 0, widest = 0;
};

struct BodyTask {
  float focal, cx, cy;
  Eigen::Isometry3f body_from_camera;
  Eigen::Vector3f lowest, highest;
};

}  // namespace
#endif

namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr D d;
constexpr hn::RebindToSigned<D> di;
constexpr hn::RebindToUnsigned<D> du;
using VU = hn::Vec<decltype(du)>;

HWY_INLINE int lanes() { return static_cast<int>(hn::Lanes(d)); }
HWY_INLINE V set(float value) { return hn::Set(d, value); }
HWY_INLINE V zero() { return hn::Zero(d); }

/// The nearest whole number to 0 <= v < 2^16.
HWY_INLINE VU whole(V v) {
  constexpr float kToWhole = 12582912;  // 1.5 * 2^23: the sum's lower bits are the number
  return hn::And(hn::BitCast(du, hn::Add(v, set(kToWhole))), hn::Set(du, 0xffffU));
}

/// a x + b y + c z
HWY_INLINE V dot(const float* row, V x, V y, V z) {
  return hn::Add(hn::Add(hn::Mul(set(row[0]), x), hn::Mul(set(row[1]), y)), hn::Mul(set(row[2]), z));
}

HWY_INLINE unsigned bits_of(M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0] | static_cast<unsigned>(bytes[1]) << 8;
}

/// The slope of inverse depth per sample between two neighbours: central on one surface, to one side at an
/// edge, level where neither side belongs to the surface.
HWY_INLINE V slope(V before, V w, V after, V tolerance, float taps, float tap) {
  const V down = hn::Sub(w, before), up = hn::Sub(after, w);
  const auto has_down = hn::Gt(before, set(kLeastKnown)), has_up = hn::Gt(after, set(kLeastKnown));
  const V bend = hn::Abs(hn::Sub(up, down));
  const auto central = hn::And(hn::And(has_down, has_up), hn::Le(bend, hn::Add(tolerance, tolerance)));
  const V limit = hn::Mul(tolerance, set(taps));
  const V level_down = hn::IfThenElseZero(hn::And(has_down, hn::Le(hn::Abs(down), limit)), down);
  const V level_up = hn::IfThenElseZero(hn::And(has_up, hn::Le(hn::Abs(up), limit)), up);
  const auto use_down = hn::And(has_down, hn::Or(hn::Not(has_up), hn::Le(hn::Abs(down), hn::Abs(up))));
  const V one_sided = hn::IfThenElse(use_down, level_down, level_up);
  const V both = hn::Mul(hn::Add(up, down), set(0.5F));
  return hn::Mul(hn::IfThenElse(central, both, one_sided), set(tap));
}

/// Marks the voxels of points on rays (x, y, 1) at inverse depth w.
HWY_INLINE void mark(const DescribeTask& t, V x, V y, V w, M where) {
  const V z = hn::Div(set(1), hn::Max(w, set(kLeastKnown)));
  where = hn::And(where, hn::Le(z, set(t.far)));
  V at[3];
  for (int k = 0; k < 3; ++k) {
    const float row[3] = {t.frame.turn(k, 0), t.frame.turn(k, 1), t.frame.turn(k, 2)};
    at[k] = hn::Add(hn::Mul(dot(row, x, y, set(1)), z), set(t.frame.origin[k]));
    const auto end = static_cast<float>(t.frame.bricks[k] * kBrickEdge);
    where = hn::And(where, hn::And(hn::Ge(at[k], zero()), hn::Lt(at[k], set(end))));
  }
  unsigned left = bits_of(where);
  if (left == 0) return;
  HWY_ALIGN std::int32_t voxel[3][HWY_MAX_BYTES / sizeof(float)];
  for (int k = 0; k < 3; ++k) hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(where, at[k])), di, voxel[k]);
  for (; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const int vx = voxel[0][i], vy = voxel[1][i], vz = voxel[2][i];
    const int brick = ((vz >> 3) * t.frame.bricks.y() + (vy >> 3)) * t.frame.bricks.x() + (vx >> 3);
    t.marks.mark(static_cast<std::uint32_t>(brick),
                 static_cast<std::uint32_t>(in_brick(vx & 7, vy & 7, vz & 7)));
  }
}

HWY_INLINE std::uint32_t most_of(VU v) {
  HWY_ALIGN std::uint32_t lane[HWY_MAX_BYTES / sizeof(float)];
  hn::Store(v, du, lane);
  return *std::max_element(lane, lane + lanes());
}

struct Extremes {
  V nearest, farthest;
};

/// Of the eight neighbours' inverse depths.
HWY_INLINE Extremes around(const float* above, const float* here, const float* below) {
  const auto at = [](const float* p) HWY_ATTR { return hn::LoadU(d, p); };
  const V a = at(above - 1), b = at(above), c = at(above + 1), e = at(here - 1), f = at(here + 1),
          g = at(below - 1), h = at(below), i = at(below + 1);
  const auto of_all = [](V p, V q, V r, V s, V t, V u, V v, V w, auto better) HWY_ATTR {
    return better(better(better(p, q), better(r, s)), better(better(t, u), better(v, w)));
  };
  return {of_all(a, b, c, e, f, g, h, i, [](V p, V q) HWY_ATTR { return hn::Max(p, q); }),
          of_all(a, b, c, e, f, g, h, i, [](V p, V q) HWY_ATTR { return hn::Min(p, q); })};
}

RowCounts describe_row(const DescribeTask& t, int y, SampleWord* out) {
  RowCounts counts;
  VU farthest = hn::Zero(du), widest = hn::Zero(du);
  const int width = t.w.width();
  const auto taps = static_cast<float>(t.taps);
  const float *above = t.w.row(y - 1), *here = t.w.row(y), *below = t.w.row(y + 1);
  const float *up = t.w.row(y - t.taps), *down = t.w.row(y + t.taps), *sigmas = t.sigma.row(y),
              *mean_sigmas = t.mean_sigma.row(y);
  const float sample = 1 / t.focal, tap = 1 / taps;
  const V ray_y = set((static_cast<float>(y) - t.cy) * sample), lane = hn::Iota(d, 0);
  for (int x = 0; x < width; x += lanes()) {
    const V own = hn::LoadU(d, here + x), sigma = hn::LoadU(d, sigmas + x);
    const auto known = hn::Gt(own, set(kLeastKnown));
    const V tolerance =
        hn::Max(hn::Mul(set(4), sigma), hn::Mul(set(t.resolution), hn::Mul(own, own)));  // one surface
    V slope_u =
        slope(hn::LoadU(d, here + x - t.taps), own, hn::LoadU(d, here + x + t.taps), tolerance, taps, tap);
    V slope_v = slope(hn::LoadU(d, up + x), own, hn::LoadU(d, down + x), tolerance, taps, tap);
    // So steep that the plane would run away within the sample: no surface that a camera measures.
    const auto steep = hn::Gt(hn::Add(hn::Abs(slope_u), hn::Abs(slope_v)), hn::Mul(own, set(0.5F)));
    slope_u = hn::IfThenZeroElse(steep, slope_u);
    slope_v = hn::IfThenZeroElse(steep, slope_v);

    // Beside a nearer surface a sample is taken for a part of that one: what is thinner than a voxel, or
    // passed by between two samples, is then not emptied.
    const V lean = hn::Add(hn::Abs(slope_u), hn::Abs(slope_v));
    const V step = hn::Add(tolerance, lean);
    const Extremes e = around(above + x, here + x, below + x);
    const auto beside = hn::And(known, hn::Lt(hn::Add(own, step), e.nearest));
    const auto edge = hn::And(known, hn::Or(beside, hn::Lt(hn::Add(e.farthest, step), own)));
    const V w = hn::IfThenElse(beside, e.nearest, own);

    // The plane n.P = 1: its normal is the gradient of w over (x, y, 1). Half the depth of a voxel that it
    // just touches: |Q - P| along the ray over Z is |n.(Q - P)|, at most |n|_1 half an edge in the map's
    // axes.
    const V ray_x = hn::Mul(hn::Add(lane, set(static_cast<float>(x) - t.cx)), set(sample));
    const V nx = hn::Mul(slope_u, set(t.focal)), ny = hn::Mul(slope_v, set(t.focal));
    const V nz = hn::Sub(hn::Sub(w, hn::Mul(nx, ray_x)), hn::Mul(ny, ray_y));
    V size = zero();
    for (int k = 0; k < 3; ++k) size = hn::Add(size, hn::Abs(dot(t.turn + 3 * k, nx, ny, nz)));
    const V z = hn::Div(set(1), hn::Max(w, set(kLeastKnown))), zz = hn::Mul(z, z);
    const V half = hn::Min(hn::Mul(hn::Mul(set(t.half_edge), size), z), set(t.most_half));
    const V sigma_z = hn::Mul(hn::LoadU(d, mean_sigmas + x), zz);

    const V lowest = zero(), most = set(kMost), steps = set(t.steps_per_metre);
    // The surface falls away within the sample; what it may still reach is not emptied.
    const V fall = hn::Mul(set(kFall), hn::Mul(lean, zz));
    V front =
        hn::Sub(hn::Sub(z, hn::Mul(half, set(kKept))), hn::Add(fall, hn::Mul(set(t.free_sigmas), sigma_z)));
    V back = hn::Add(hn::Add(z, half), hn::Mul(set(t.hit_sigmas), sigma_z));
    front = hn::Sub(hn::Mul(front, steps), set(0.5F));
    back = hn::Add(hn::Mul(back, steps), set(0.5F));
    const auto within = hn::RebindMask(du, hn::And(hn::Ge(front, lowest), hn::Le(back, most)));
    const VU front_steps = whole(hn::Max(hn::Min(front, most), lowest));
    // What does not lie within the steps from front to back is hit nowhere: shares of the rest of its way
    // would be other places.
    const VU back_steps = hn::IfThenElse(within, whole(hn::Min(back, most)), front_steps);
    const V wide = hn::Div(hn::Mul(set(SampleClasses::kCount), sigma_z), hn::Add(sigma_z, half));
    const VU kind = whole(hn::Min(wide, set(SampleClasses::kCount - 1)));
    VU word = hn::Or(hn::ShiftLeft<sample_word::kFrontShift>(front_steps),
                     hn::Or(hn::ShiftLeft<sample_word::kBackShift>(back_steps), kind));
    word = hn::IfThenElseZero(hn::RebindMask(du, known), word);
    hn::StoreU(word, du, out + x);  // zeros behind the last: nothing is known there
    farthest = hn::Max(farthest, hn::IfThenElseZero(hn::RebindMask(du, known), back_steps));
    widest = hn::Max(widest, hn::IfThenElseZero(hn::RebindMask(du, known), kind));
    counts.used += hn::CountTrue(d, known);

    if (hn::AllFalse(d, edge)) continue;
    // The sample's corners, and a little beyond where both sides of the edge are measured.
    const V reach = hn::IfThenElse(hn::Gt(e.farthest, set(kLeastKnown)), set(kBeyondCorner), set(0.5F));
    const V fall_u = hn::Mul(slope_u, reach), fall_v = hn::Mul(slope_v, reach),
            aside = hn::Mul(reach, set(sample));
    const V left_x = hn::Sub(ray_x, aside), right_x = hn::Add(ray_x, aside);
    const V top_y = hn::Sub(ray_y, aside), low_y = hn::Add(ray_y, aside);
    mark(t, left_x, top_y, hn::Sub(hn::Sub(own, fall_u), fall_v), edge);
    mark(t, right_x, top_y, hn::Sub(hn::Add(own, fall_u), fall_v), edge);
    mark(t, left_x, low_y, hn::Add(hn::Sub(own, fall_u), fall_v), edge);
    mark(t, right_x, low_y, hn::Add(hn::Add(own, fall_u), fall_v), edge);
  }
  counts.farthest = most_of(farthest);
  counts.widest = most_of(widest);
  return counts;
}

/// Forgets the samples of a row whose points lie in a box of the body's frame; returns how many.
std::size_t forget_row(const BodyTask& t, int y, int width, float* row) {
  std::size_t forgotten = 0;
  const float sample = 1 / t.focal;
  const V ray_y = set((static_cast<float>(y) - t.cy) * sample), lane = hn::Iota(d, 0);
  for (int x = 0; x < width; x += lanes()) {
    const V w = hn::LoadU(d, row + x);
    auto own = hn::Gt(w, set(kLeastKnown));
    const V z = hn::Div(set(1), hn::Max(w, set(kLeastKnown)));
    const V ray_x = hn::Mul(hn::Add(lane, set(static_cast<float>(x) - t.cx)), set(sample));
    for (int k = 0; k < 3; ++k) {
      const float turn[3] = {t.body_from_camera(k, 0), t.body_from_camera(k, 1), t.body_from_camera(k, 2)};
      const V p = hn::Add(hn::Mul(dot(turn, ray_x, ray_y, set(1)), z), set(t.body_from_camera(k, 3)));
      own = hn::And(own, hn::And(hn::Ge(p, set(t.lowest[k])), hn::Le(p, set(t.highest[k]))));
    }
    forgotten += hn::CountTrue(d, own);
    hn::StoreU(hn::IfThenZeroElse(own, w), d, row + x);
  }
  return forgotten;
}

/// Lesser fronts (lower halves) and greater backs.
HWY_INLINE VU bounds_of(VU a, VU b) {
#if HWY_TARGET == HWY_SCALAR
  const std::uint32_t p = hn::GetLane(a), q = hn::GetLane(b);
  return hn::Set(du, std::min(p & 0xffff, q & 0xffff) | std::max(p >> 16, q >> 16) << 16);
#else
  constexpr hn::Repartition<std::uint16_t, decltype(du)> half;
  const auto p = hn::BitCast(half, a), q = hn::BitCast(half, b);
  return hn::BitCast(du, hn::OddEven(hn::Max(p, q), hn::Min(p, q)));
#endif
}

/// Of pairs of neighbours in two vectors.
HWY_INLINE VU bounds_of_pairs(VU left, VU right) {
#if HWY_TARGET == HWY_SCALAR
  return bounds_of(left, right);
#else
  return bounds_of(hn::ConcatEven(du, right, left), hn::ConcatOdd(du, right, left));
#endif
}

HWY_INLINE VU as_bounds(VU word) {
  const VU front = hn::ShiftRight<sample_word::kFrontShift>(word);
  const VU back =
      hn::And(hn::ShiftRight<sample_word::kBackShift>(word), hn::Set(du, sample_word::kDepthMask));
  return hn::Or(front, hn::ShiftLeft<16>(back));
}

// One row of tiles from two rows of single samples. Vectors reach beyond the row's end; whoever calls leaves
// room for it.
void tiles_of_samples(const SampleWord* above, const SampleWord* below, int samples, int width,
                      std::uint32_t* out) {
  for (int x = 0; x < width; x += lanes()) {
    const auto at = [&](int i) HWY_ATTR {
      const VU both = bounds_of(as_bounds(hn::LoadU(du, above + i)), as_bounds(hn::LoadU(du, below + i)));
      const auto inside = hn::FirstN(du, static_cast<std::size_t>(std::max(samples - i, 0)));
      return hn::IfThenElse(inside, both, hn::Set(du, kOutside));
    };
    const VU left = at(2 * x), right = at(2 * x + lanes());
    hn::StoreU(bounds_of_pairs(left, right), du, out + x);
  }
}

/// The same from two rows of tiles of half the size.
void tiles_of_tiles(const std::uint32_t* above, const std::uint32_t* below, int width, std::uint32_t* out) {
  for (int x = 0; x < width; x += lanes()) {
    const auto at = [&](int i)
                        HWY_ATTR { return bounds_of(hn::LoadU(du, above + i), hn::LoadU(du, below + i)); };
    const VU left = at(2 * x), right = at(2 * x + lanes());
    hn::StoreU(bounds_of_pairs(left, right), du, out + x);
  }
}

/// Tiles with their right, lower and lower right neighbours.
void overlap_bounds(const std::uint32_t* here, const std::uint32_t* below, int width, std::uint32_t* out) {
  for (int x = 0; x < width; x += lanes()) {
    const auto at = [&](int i)
                        HWY_ATTR { return bounds_of(hn::LoadU(du, here + i), hn::LoadU(du, below + i)); };
    hn::StoreU(bounds_of(at(x), at(x + 1)), du, out + x);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace headway::nav
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::nav {
namespace {

HWY_EXPORT(describe_row);
HWY_EXPORT(forget_row);
HWY_EXPORT(tiles_of_samples);
HWY_EXPORT(tiles_of_tiles);
HWY_EXPORT(overlap_bounds);

// A sample stands for all rays up to half a sample off its own, so its surface is taken for somewhat thicker
// than a voxel that it just touches.
constexpr double kThickness = 1.2;

constexpr int kReach = 1,
              kFineReach = 2;  // samples that means reach, and means over these where noise is left

std::uint8_t share(double part, double whole) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(part / whole, 0.0, 255.0 / 256) * 256));
}

}  // namespace

// With q = sigma / half a voxel's depth, class c stands for q = c / (16 - c). From front to back are free
// sigmas, half a voxel, half a voxel, hit sigmas.
SampleClasses::SampleClasses(double free_sigmas, double hit_sigmas) {
  for (std::size_t c = 0; c < kCount; ++c) {
    const double q = static_cast<double>(c) / static_cast<double>(kCount - c);
    const double whole = 2 + (free_sigmas + hit_sigmas) * q;
    hit_begin[c] = share((free_sigmas - hit_sigmas) * q, whole);
    own_begin[c] = share(free_sigmas * q, whole);
    own_end[c] = share(hit_sigmas * q, whole);
    const double hit = std::max(1.0, std::round(log_odds::kHit / (1 + hit_sigmas * q)));
    short_of_hit[c] = static_cast<std::uint8_t>(log_odds::kHit - static_cast<int>(hit));
  }
}

void DepthBounds::build(const RingImage<SampleWord>& samples) {
  constexpr std::size_t kSlack = RingImage<SampleWord>::kSlack;
  int width = samples.width(), height = samples.height(), end = 0;
  for (std::size_t l = 1; l <= kLevels; ++l) {
    width = (width + 1) / 2;
    height = (height + 1) / 2;
    start_[l] = end;
    width_[l] = width + 1;  // one more stands right of the last, and a row below
    height_[l] = height;
    end += (width + 1) * (height + 1);
  }
  tiles_.resize(static_cast<std::size_t>(end) + kSlack);
  overlapping_.resize(tiles_.size());
  for (std::size_t l = 1; l <= kLevels; ++l) {
    Word* tiles = tiles_.data() + start_[l];
    const int tiles_across = width_[l] - 1;
    for (int y = 0; y < height_[l]; ++y) {
      Word* row = tiles + y * width_[l];
      if (l == 1) {
        const SampleWord* above = samples.row(2 * y);
        const SampleWord* below = 2 * y + 1 < samples.height() ? samples.row(2 * y + 1) : above;
        HWY_DYNAMIC_DISPATCH(tiles_of_samples)(above, below, samples.width(), tiles_across, row);
      } else {
        const Word* above = tiles_.data() + start_[l - 1] + 2 * y * width_[l - 1];
        HWY_DYNAMIC_DISPATCH(tiles_of_tiles)(above, above + width_[l - 1], tiles_across, row);
      }
      row[tiles_across] = kOutside;
    }
    std::fill_n(tiles + height_[l] * width_[l], width_[l], kOutside);
  }
  for (std::size_t l = 1; l <= kLevels; ++l) {
    for (int y = 0; y < height_[l]; ++y) {
      const Word* row = tiles_.data() + start_[l] + y * width_[l];
      HWY_DYNAMIC_DISPATCH(overlap_bounds)
      (row, row + width_[l], width_[l], overlapping_.data() + start_[l] + y * width_[l]);
    }
  }
}

void RangeSamples::take(const vision::RangeView& view, const IntegrationConfig& config,
                        const Sampling& sampling, const Eigen::Matrix3d& map_from_camera,
                        const Eigen::Isometry3d& body_from_camera, const MarkFrame& frame,
                        VoxelMarks& marks) {
  // A voxel at the far end should still be about as wide as a sample.
  const double pixels_per_voxel = view.camera.focal * sampling.resolution / view.far;
  const int reduction = pixels_per_voxel >= 4 ? 4 : pixels_per_voxel >= 2 ? 2 : 1;
  set_camera(view.camera, reduction);
  near_ = static_cast<float>(view.near);
  far_ = static_cast<float>(view.far);
  const auto edge = static_cast<float>(sampling.resolution);
  reducer_.reduce(view, static_cast<float>(config.least_weight), edge, {reduction, sampling.rows}, rough_);
  rejected_ = used_ = 0;
  farthest_ = widest_ = 0;
  if (!config.own_body.empty()) forget_own_body(config.own_body, body_from_camera);
  rejected_ += smooth(rough_.w, rough_.sigma, kReach, config.supporters, edge, smooth_, &mean_sigma_);
  const bool fine = reduction < 4;  // noise of fewer pixels is left in each sample
  if (fine) fill_holes(rough_, edge, smooth_, mean_sigma_);
  if (fine) rejected_ += smooth(smooth_, rough_.sigma, kFineReach, 0, edge, smoother_);

  const RingImage<float>& w = fine ? smoother_ : smooth_;
  const double errors = sample_errors(w, rough_.sigma, 2 * (fine ? kReach + kFineReach : kReach) + 2);
  hit_sigmas_ = std::max(config.least_hit_sigmas, std::min(1.0, config.hit_errors * errors));

  steps_per_metre_ = kMost / (kBeyondFar * far_);
  const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> turn = map_from_camera.cast<float>();
  const DescribeTask task{w,
                          rough_.sigma,
                          mean_sigma_,
                          focal_,
                          cx_,
                          cy_,
                          far_,
                          steps_per_metre_,
                          static_cast<float>(kThickness * sampling.resolution / 2),
                          static_cast<float>(config.longest_hit * sampling.resolution),
                          edge,
                          static_cast<float>(config.free_sigmas),
                          static_cast<float>(hit_sigmas_),
                          fine ? 2 : 1,
                          turn.data(),
                          frame,
                          marks};
  words_.reset(task.w.width(), task.w.height());
  for (int y = 0; y < words_.height(); ++y) {
    const RowCounts row = HWY_DYNAMIC_DISPATCH(describe_row)(task, y, words_.row(y));
    used_ += row.used;
    farthest_ = std::max(farthest_, row.farthest);
    widest_ = std::max(widest_, row.widest);
  }
  bounds_.build(words_);
}

void RangeSamples::set_camera(const vision::PinholeCamera& camera, int reduction) {
  const double first_centre = (reduction - 1) / 2.0;
  focal_ = static_cast<float>(camera.focal / reduction);
  cx_ = static_cast<float>((camera.cx - first_centre) / reduction);
  cy_ = static_cast<float>((camera.cy - first_centre) / reduction);
  end_u_ = static_cast<float>(camera.width) / static_cast<float>(reduction) - 0.5F;
  end_v_ = static_cast<float>(camera.height) / static_cast<float>(reduction) - 0.5F;
}

void RangeSamples::forget_own_body(const std::vector<BodyBox>& boxes,
                                   const Eigen::Isometry3d& body_from_camera) {
  for (const BodyBox& box : boxes) {
    const BodyTask task{focal_,
                        cx_,
                        cy_,
                        body_from_camera.cast<float>(),
                        box.lowest.cast<float>(),
                        box.highest.cast<float>()};
    for (int y = 0; y < rough_.w.height(); ++y)
      rejected_ += HWY_DYNAMIC_DISPATCH(forget_row)(task, y, rough_.w.width(), rough_.w.row(y));
  }
}

}  // namespace headway::nav
#endif
