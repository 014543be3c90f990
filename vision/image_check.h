// Looks an image file over before it is decoded. Decoders print complaints of their own, allocate before they
// find out, or paint what is missing grey.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace headway::vision {

/// What is wrong with the bytes of a PNG, JPEG or binary PGM/PPM file: not one of these, truncated, damaged
/// (PNG has checksums) or too large. A sentence that follows the file's name; empty when nothing is wrong.
std::string image_fault(std::span<const std::uint8_t> bytes, double largest_megapixels);

}  // namespace headway::vision
