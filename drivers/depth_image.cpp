#include "drivers/depth_image.h"

#include <limits>

namespace headway::drivers {

bool copy_depth(std::span<const std::uint8_t> data, const ImageLayout& layout, double metres_per_count,
                hal::DepthFrame& into) {
  if (layout.format != PixelFormat::kZ16 || data.size() < least_bytes(layout)) return false;
  const auto width = static_cast<std::size_t>(layout.width), height = static_cast<std::size_t>(layout.height);
  into.width = layout.width;
  into.height = layout.height;
  into.depth.resize(width * height);
  for (std::size_t y = 0; y < height; ++y) {
    const std::uint8_t* row = &data[y * layout.stride];
    for (std::size_t x = 0; x < width; ++x) {
      const unsigned count = row[2 * x] | static_cast<unsigned>(row[2 * x + 1]) << 8;
      into.depth[y * width + x] =
          count == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(count * metres_per_count);
    }
  }
  return true;
}

}  // namespace headway::drivers
