// A depth camera's Z16 frame to distances in metres.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/pixel_format.h"
#include "hal/frame.h"

namespace headway::drivers {

/// Fills the frame's image: Z [m] = count * metres_per_count, NaN where the count is 0. False, and `into`
/// untouched, for other formats and for data that is less than least_bytes(layout). Allocates only when
/// `into` is smaller than the image.
bool copy_depth(std::span<const std::uint8_t> data, const ImageLayout& layout, double metres_per_count,
                hal::DepthFrame& into);

}  // namespace headway::drivers
