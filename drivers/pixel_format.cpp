#include "drivers/pixel_format.h"

#include <linux/videodev2.h>

namespace headway::drivers {

std::uint32_t code_of(PixelFormat format) noexcept {
  switch (format) {
    case PixelFormat::kGrey:
      return V4L2_PIX_FMT_GREY;
    case PixelFormat::kY16:
      return V4L2_PIX_FMT_Y16;
    case PixelFormat::kYuyv:
      return V4L2_PIX_FMT_YUYV;
    case PixelFormat::kNv12:
      return V4L2_PIX_FMT_NV12;
    case PixelFormat::kMjpeg:
      return V4L2_PIX_FMT_MJPEG;
    case PixelFormat::kZ16:
      return V4L2_PIX_FMT_Z16;
  }
  return 0;
}

std::optional<PixelFormat> format_of(std::uint32_t code) noexcept {
  for (const PixelFormat format : kPixelFormats) {
    if (code_of(format) == code) return format;
  }
  return std::nullopt;
}

std::string code_text(std::uint32_t code) {
  std::string text;
  for (int i = 0; i < 4; ++i) {
    // The highest bit tells big-endian variants apart; it is no part of the character.
    const auto c = static_cast<char>((code >> (8 * i)) & 0x7F);
    text += c >= ' ' && c <= '~' ? c : '.';
  }
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

std::vector<std::string> image_format_names() {
  std::vector<std::string> names;
  for (const PixelFormat format : kPixelFormats)
    if (format != PixelFormat::kZ16) names.push_back(code_text(code_of(format)));
  return names;
}

std::optional<PixelFormat> image_format_named(std::string_view name) {
  for (const PixelFormat format : kPixelFormats)
    if (format != PixelFormat::kZ16 && code_text(code_of(format)) == name) return format;
  return std::nullopt;
}

std::size_t row_bytes(PixelFormat format, int width) noexcept {
  const auto pixels = static_cast<std::size_t>(width);
  switch (format) {
    case PixelFormat::kGrey:
    case PixelFormat::kNv12:
      return pixels;
    case PixelFormat::kY16:
    case PixelFormat::kYuyv:
    case PixelFormat::kZ16:
      return 2 * pixels;
    case PixelFormat::kMjpeg:
      return 0;
  }
  return 0;
}

std::size_t least_bytes(const ImageLayout& layout) noexcept {
  if (layout.format == PixelFormat::kMjpeg) return 4;  // its first and its last marker
  const bool has_colours = layout.format == PixelFormat::kNv12;
  const auto height = static_cast<std::size_t>(layout.height);
  const std::size_t rows = height + (has_colours ? (height + 1) / 2 : 0);
  return (rows - 1) * layout.stride + row_bytes(layout.format, layout.width);
}

}  // namespace headway::drivers
