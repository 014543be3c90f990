// Looks a PNG file over before it is decoded: libpng would print its own complaints, and allocate first.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace headway::vision {

/// True when the bytes begin as a PNG file does.
bool is_png(std::span<const std::uint8_t> bytes);

/// What is wrong with a PNG file: "is truncated", "is damaged" (a checksum), or too large; empty when nothing
/// is.
std::string png_fault(std::span<const std::uint8_t> bytes, double largest_megapixels);

}  // namespace headway::vision
