#include "drivers/grey_image.h"

#include <algorithm>

namespace headway::drivers {

namespace {

void copy_row(const std::uint8_t* from, std::span<std::uint8_t> to, PixelFormat format, int bits) {
  switch (format) {
    case PixelFormat::kYuyv:
      for (std::size_t x = 0; x < to.size(); ++x) to[x] = from[2 * x];
      break;
    case PixelFormat::kY16:
      for (std::size_t x = 0; x < to.size(); ++x) {
        const unsigned value = from[2 * x] | static_cast<unsigned>(from[2 * x + 1]) << 8;
        to[x] = static_cast<std::uint8_t>(std::min(value >> (bits - 8), 255U));
      }
      break;
    default:
      std::copy_n(from, to.size(), to.data());
  }
}

}  // namespace

bool copy_grey(std::span<const std::uint8_t> data, const ImageLayout& layout, int bits,
               hal::GrayImage& into) {
  const bool is_grey = layout.format != PixelFormat::kMjpeg && layout.format != PixelFormat::kZ16;
  if (!is_grey || data.size() < least_bytes(layout)) return false;
  const auto width = static_cast<std::size_t>(layout.width), height = static_cast<std::size_t>(layout.height);
  into.width = layout.width;
  into.height = layout.height;
  into.pixels.resize(width * height);
  const std::span<std::uint8_t> pixels(into.pixels);
  for (std::size_t y = 0; y < height; ++y)
    copy_row(&data[y * layout.stride], pixels.subspan(y * width, width), layout.format, bits);
  return true;
}

}  // namespace headway::drivers
