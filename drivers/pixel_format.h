// The pixel formats that Headway reads from cameras, and how an image lies in memory
// (kernel documentation: userspace-api/media/v4l/pixfmt).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace headway::drivers {

enum class PixelFormat : std::uint8_t {
  kGrey,   ///< 8 bits
  kY16,    ///< 16 bits, little-endian; a sensor may use the lower ones only
  kYuyv,   ///< luma in every other byte
  kNv12,   ///< a luma plane, then one of colours at half the size
  kMjpeg,  ///< JPEG images
  kZ16,    ///< distance along the optical axis, 16 bits, little-endian; 0: nothing measured
};

inline constexpr std::array kPixelFormats{PixelFormat::kGrey, PixelFormat::kY16,   PixelFormat::kYuyv,
                                          PixelFormat::kNv12, PixelFormat::kMjpeg, PixelFormat::kZ16};

/// V4L2's code of a format.
std::uint32_t code_of(PixelFormat format) noexcept;
/// None: a format that Headway does not read.
std::optional<PixelFormat> format_of(std::uint32_t code) noexcept;
/// The four characters of a code, those that cannot be printed as dots; without spaces at the end.
std::string code_text(std::uint32_t code);

/// The names of the formats that show images, and not distances: GREY, Y16, YUYV, NV12, MJPG.
std::vector<std::string> image_format_names();
/// By such a name. None: there is none of that name.
std::optional<PixelFormat> image_format_named(std::string_view name);

struct ImageLayout {
  PixelFormat format = PixelFormat::kGrey;
  int width = 0, height = 0;
  std::size_t stride = 0;  ///< bytes from row to row; of JPEG images none

  friend bool operator==(const ImageLayout&, const ImageLayout&) = default;
};

/// Bytes of one row's pixels, without padding; 0 for JPEG.
std::size_t row_bytes(PixelFormat format, int width) noexcept;
/// Bytes that a whole frame has at least. The padding of the last row may be missing.
std::size_t least_bytes(const ImageLayout& layout) noexcept;

}  // namespace headway::drivers
