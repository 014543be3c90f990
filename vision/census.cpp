#include "vision/census.h"

#include <algorithm>
#include <iterator>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/census.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace headway::vision::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Two pixels of the window that are compared, relative to the centre.
struct Pair {
  int ax, ay, bx, by;
};
constexpr Pair kPairs[Census::kBits] = {
    {-2, -2, 2, 2}, {-1, -2, 1, 2}, {0, -2, 0, 2},  {1, -2, -1, 2}, {2, -2, -2, 2}, {-2, -1, 2, 1},
    {-1, -1, 1, 1}, {0, -1, 0, 1},  {1, -1, -1, 1}, {2, -1, -2, 1}, {-2, 0, 2, 0},  {-1, 0, 1, 0},
    {-1, -1, 0, 0}, {0, -1, 0, 0},  {1, -1, 0, 0},  {-1, 0, 0, 0},  {1, 0, 0, 0},   {-1, 1, 0, 0},
    {0, 1, 0, 0},   {1, 1, 0, 0},   {-2, -2, 0, 0}, {2, -2, 0, 0},  {-2, 2, 0, 0},  {2, 2, 0, 0}};

/// One row of the planes of comparisons. `centre` points into an image with border; kTurn is -1 in a mirror
/// image, where the window is mirrored with it.
template <int kTurn>
void compare_row(const std::int8_t* centre, std::ptrdiff_t pitch, int width, std::uint8_t* const* planes) {
  const hn::ScalableTag<std::int8_t> d;
  const hn::RebindToUnsigned<decltype(d)> bytes;
  const std::int8_t* rows[] = {centre - 2 * pitch, centre - pitch, centre, centre + pitch,
                               centre + 2 * pitch};
  std::uint8_t* out[] = {planes[0], planes[1], planes[2]};
  for (int x = 0; x < width; x += static_cast<int>(hn::Lanes(d))) {
    const auto at = [&](int right, int down)
                        HWY_ATTR { return hn::LoadU(d, rows[2 + down] + x + kTurn * right); };
    HWY_UNROLL(3)
    for (int plane = 0; plane < Census::kBitPlanes; ++plane) {
      auto bits = hn::Zero(d);
      HWY_UNROLL(8)
      for (int bit = 0; bit < 8; ++bit) {
        const Pair& p = kPairs[8 * plane + bit];
        const auto weight = hn::Set(d, static_cast<std::int8_t>(1 << bit));
        bits = hn::Or(bits, hn::IfThenElseZero(hn::Gt(at(p.ax, p.ay), at(p.bx, p.by)), weight));
      }
      hn::StoreU(hn::BitCast(bytes, bits), bytes, out[plane] + x);
    }
  }
}

/// One row of the plane of slopes.
void slope_row(const std::int8_t* centre, std::ptrdiff_t pitch, int turn, int width, std::uint8_t* out) {
  const hn::ScalableTag<std::int16_t> d;
  const hn::Rebind<std::int8_t, decltype(d)> bytes;
  const hn::Rebind<std::uint8_t, decltype(d)> out_bytes;
  const auto cap = hn::Set(d, Census::kSteepest);
  for (int x = 0; x < width; x += static_cast<int>(hn::Lanes(d))) {
    const auto rise = [&](std::ptrdiff_t row) HWY_ATTR {
      const std::int8_t* p = centre + x + row * pitch;
      return hn::Sub(hn::PromoteTo(d, hn::LoadU(bytes, p + turn)),
                     hn::PromoteTo(d, hn::LoadU(bytes, p - turn)));
    };
    const auto middle = rise(0);
    const auto sobel = hn::Add(hn::Add(rise(-1), rise(1)), hn::Add(middle, middle));
    const auto quarter = hn::ShiftRight<2>(hn::Add(sobel, hn::Set(d, 2)));
    const auto cut = hn::Max(hn::Min(quarter, cap), hn::Neg(cap));
    hn::StoreU(hn::DemoteTo(out_bytes, hn::Add(cut, hn::Set(d, Census::kLevel))), out_bytes, out + x);
  }
}

}  // namespace

void CensusRow(const std::int8_t* centre, std::ptrdiff_t pitch, int turn, int width,
               std::uint8_t* const* planes) {
  if (turn > 0)
    compare_row<1>(centre, pitch, width, planes);
  else
    compare_row<-1>(centre, pitch, width, planes);
  slope_row(centre, pitch, turn, width, planes[Census::kSlopePlane]);
}

}  // namespace headway::vision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {

namespace {

HWY_EXPORT(CensusRow);

constexpr int kBorder = 2;         // of the window around its centre
constexpr int kWidestVector = 64;  // bytes that a row may be read and written beyond its end

}  // namespace

void Census::compute(const hal::GrayImage& image, bool mirrored, int margin) {
  const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
  const std::size_t padded_pitch = width + 2 * kBorder + kWidestVector;
  margin_ = static_cast<std::size_t>(margin);
  pitch_ = width + 2 * margin_ + kWidestVector;
  planes_.resize(pitch_ * height * kPlanes);
  padded_.resize(padded_pitch * (height + 2 * kBorder));

  for (std::size_t row = 0; row < height + 2 * kBorder; ++row) {
    const std::size_t y = std::min(row < kBorder ? 0 : row - kBorder, height - 1);
    const std::uint8_t* from = image.pixels.data() + y * width;
    std::int8_t* to = padded_.data() + row * padded_pitch;
    const auto less_128 = [](std::uint8_t grey) { return static_cast<std::int8_t>(grey - 128); };
    if (mirrored)
      std::transform(from, from + width, std::make_reverse_iterator(to + kBorder + width), less_128);
    else
      std::transform(from, from + width, to + kBorder, less_128);
    std::fill_n(to, kBorder, to[kBorder]);
    std::fill_n(to + kBorder + width, kBorder + kWidestVector, to[kBorder + width - 1]);
  }
  for (std::size_t y = 0; y < height; ++y) {
    std::uint8_t* rows[kPlanes];
    for (std::size_t p = 0; p < kPlanes; ++p) rows[p] = planes_.data() + (y * kPlanes + p) * pitch_ + margin_;
    HWY_DYNAMIC_DISPATCH(CensusRow)
    (padded_.data() + (y + kBorder) * padded_pitch + kBorder, static_cast<std::ptrdiff_t>(padded_pitch),
     mirrored ? -1 : 1, image.width, rows);
  }
}

}  // namespace headway::vision
#endif
