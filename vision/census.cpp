#include "vision/census.h"

#include <algorithm>

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

/// One row of the three planes of comparisons. `centre` points into an image with border; `turn` is -1 in a
/// mirror image, where the window is mirrored with it.
void compare_row(const std::uint8_t* centre, std::ptrdiff_t pitch, int turn, int width,
                 std::uint8_t* const* planes) {
  const hn::ScalableTag<std::uint8_t> d;
  for (int x = 0; x < width; x += static_cast<int>(hn::Lanes(d))) {
    for (int plane = 0; plane < 3; ++plane) {
      auto bits = hn::Zero(d);
      for (int bit = 0; bit < 8; ++bit) {
        const Pair& p = kPairs[8 * plane + bit];
        const auto a = hn::LoadU(d, centre + x + p.ay * pitch + turn * p.ax);
        const auto b = hn::LoadU(d, centre + x + p.by * pitch + turn * p.bx);
        bits =
            hn::Or(bits, hn::IfThenElseZero(hn::Gt(a, b), hn::Set(d, static_cast<std::uint8_t>(1 << bit))));
      }
      hn::StoreU(bits, d, planes[plane] + x);
    }
  }
}

/// One row of the plane of slopes.
void slope_row(const std::uint8_t* centre, std::ptrdiff_t pitch, int turn, int width, std::uint8_t* out) {
  const hn::ScalableTag<std::int16_t> d;
  const hn::Rebind<std::uint8_t, decltype(d)> bytes;
  const auto cap = hn::Set(d, Census::kSteepest);
  for (int x = 0; x < width; x += static_cast<int>(hn::Lanes(d))) {
    const auto rise = [&](std::ptrdiff_t row) HWY_ATTR {
      const std::uint8_t* p = centre + x + row * pitch;
      return hn::Sub(hn::PromoteTo(d, hn::LoadU(bytes, p + turn)),
                     hn::PromoteTo(d, hn::LoadU(bytes, p - turn)));
    };
    const auto middle = rise(0);
    const auto sobel = hn::Add(hn::Add(rise(-1), rise(1)), hn::Add(middle, middle));
    const auto quarter = hn::ShiftRight<2>(hn::Add(sobel, hn::Set(d, 2)));
    const auto cut = hn::Max(hn::Min(quarter, cap), hn::Neg(cap));
    hn::StoreU(hn::DemoteTo(bytes, hn::Add(cut, hn::Set(d, Census::kLevel))), bytes, out + x);
  }
}

}  // namespace

void CensusRow(const std::uint8_t* centre, std::ptrdiff_t pitch, int turn, int width,
               std::uint8_t* const* planes) {
  compare_row(centre, pitch, turn, width, planes);
  slope_row(centre, pitch, turn, width, planes[3]);
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
  for (auto& plane : planes_) plane.resize(pitch_ * height);
  padded_.resize(padded_pitch * (height + 2 * kBorder));

  for (std::size_t row = 0; row < height + 2 * kBorder; ++row) {
    const std::size_t y = std::min(row < kBorder ? 0 : row - kBorder, height - 1);
    const std::uint8_t* from = image.pixels.data() + y * width;
    std::uint8_t* to = padded_.data() + row * padded_pitch;
    if (mirrored)
      std::reverse_copy(from, from + width, to + kBorder);
    else
      std::copy(from, from + width, to + kBorder);
    std::fill_n(to, kBorder, to[kBorder]);
    std::fill_n(to + kBorder + width, kBorder + kWidestVector, to[kBorder + width - 1]);
  }
  for (std::size_t y = 0; y < height; ++y) {
    std::uint8_t* rows[kPlanes];
    for (std::size_t p = 0; p < kPlanes; ++p) rows[p] = planes_[p].data() + y * pitch_ + margin_;
    HWY_DYNAMIC_DISPATCH(CensusRow)
    (padded_.data() + (y + kBorder) * padded_pitch + kBorder, static_cast<std::ptrdiff_t>(padded_pitch),
     mirrored ? -1 : 1, image.width, rows);
  }
}

}  // namespace headway::vision
#endif
