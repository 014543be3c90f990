// A camera's uncompressed frame to 8-bit grey values.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/pixel_format.h"
#include "hal/frame.h"

namespace headway::drivers {

/// Copies the luma of a frame of GREY, Y16, YUYV or NV12; of Y16 with `bits` significant bits (8..16) the
/// highest 8, brighter values clipped. False, and `into` untouched, for other formats and for data that is
/// less than least_bytes(layout). Allocates only when `into` is smaller than the image.
bool copy_grey(std::span<const std::uint8_t> data, const ImageLayout& layout, int bits, hal::GrayImage& into);

}  // namespace headway::drivers
