#include "vision/image_check.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>

#include <fmt/format.h>

namespace headway::vision {

namespace {

using Bytes = std::span<const std::uint8_t>;

const std::string kTruncated = "is truncated; export or copy the image again";

std::string damaged(std::string_view how) {
  return fmt::format("is damaged ({}); export or copy the image again", how);
}

std::string size_fault(double width, double height, double largest_megapixels) {
  if (width < 1 || height < 1) return damaged("it has no pixels");
  if (1e-6 * width * height <= largest_megapixels) return "";
  return fmt::format("has {:.6g} megapixels, expected at most {:.6g}", 1e-6 * width * height,
                     largest_megapixels);
}

std::uint32_t big_endian(Bytes b, std::size_t at, int bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i) value = value << 8 | b[at + static_cast<std::size_t>(i)];
  return value;
}

bool starts_with(Bytes bytes, std::string_view text) {
  return bytes.size() >= text.size() &&
         std::equal(text.begin(), text.end(), bytes.begin(),
                    [](char c, std::uint8_t b) { return static_cast<std::uint8_t>(c) == b; });
}

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = (c & 1) ? 0xEDB88320U ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  return table;
}

// CRC-32 (PNG specification, annex D).
std::uint32_t crc(Bytes b) {
  static constexpr auto kTable = crc_table();
  std::uint32_t c = 0xFFFFFFFFU;
  for (const std::uint8_t byte : b) c = kTable[(c ^ byte) & 0xFF] ^ (c >> 8);
  return ~c;
}

constexpr std::string_view kPng = "\x89PNG\r\n\x1A\n";

// Walks the chunks: length, type, data, checksum of type and data.
std::string png_fault(Bytes bytes, double largest_megapixels) {
  constexpr std::size_t kFrame = 12;
  bool first = true;
  for (std::size_t at = kPng.size(); at + kFrame <= bytes.size();) {
    const std::size_t length = big_endian(bytes, at, 4);
    if (length > bytes.size() - at - kFrame) return kTruncated;
    const std::string_view type(reinterpret_cast<const char*>(bytes.data()) + at + 4, 4);
    if (crc(bytes.subspan(at + 4, length + 4)) != big_endian(bytes, at + 8 + length, 4))
      return damaged(fmt::format("checksum at byte {}", at));
    if (first && (type != "IHDR" || length != 13)) return damaged("no header");
    if (first)
      if (auto fault =
              size_fault(big_endian(bytes, at + 8, 4), big_endian(bytes, at + 12, 4), largest_megapixels);
          !fault.empty())
        return fault;
    first = false;
    if (type == "IEND") return "";
    at += length + kFrame;
  }
  return kTruncated;
}

bool has_end_of_jpeg(Bytes b) {
  const std::size_t tail = b.size() > 64 ? b.size() - 64 : 2;  // some cameras pad
  for (std::size_t i = b.size() - 1; i > tail; --i)
    if (b[i - 1] == 0xFF && b[i] == 0xD9) return true;
  return false;
}

// Walks the segments (marker, length) to the frame header, which holds the size.
std::string jpeg_fault(Bytes bytes, double largest_megapixels) {
  for (std::size_t at = 2; at + 9 <= bytes.size();) {
    if (bytes[at] != 0xFF) return damaged("a segment does not begin where it should");
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) {
      auto fault = size_fault(big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2), largest_megapixels);
      return !fault.empty() ? fault : has_end_of_jpeg(bytes) ? "" : kTruncated;
    }
    at += 2 + std::max<std::size_t>(2, big_endian(bytes, at + 2, 2));
  }
  return kTruncated;
}

// The next number of a PNM header, after white space and comments; leaves `at` behind it.
std::optional<std::uint32_t> header_number(Bytes b, std::size_t& at) {
  while (at < b.size() && (std::isspace(b[at]) || b[at] == '#'))
    if (b[at++] == '#')
      while (at < b.size() && b[at] != '\n') ++at;
  std::uint32_t value = 0;
  int digits = 0;
  for (; at < b.size() && std::isdigit(b[at]) && digits < 8; ++at, ++digits)
    value = 10 * value + static_cast<std::uint32_t>(b[at] - '0');
  return digits == 0 ? std::nullopt : std::optional(value);
}

std::string pnm_fault(Bytes bytes, double largest_megapixels) {
  std::size_t at = 2;
  const auto width = header_number(bytes, at), height = header_number(bytes, at),
             largest = header_number(bytes, at);
  if (!width || !height || !largest || *largest < 1 || *largest > 65535) return damaged("its header");
  if (auto fault = size_fault(*width, *height, largest_megapixels); !fault.empty()) return fault;
  const std::size_t channels = bytes[1] == '6' ? 3 : 1, depth = *largest > 255 ? 2 : 1;
  return bytes.size() - at < 1 + std::size_t{*width} * *height * channels * depth ? kTruncated : "";
}

}  // namespace

std::string image_fault(Bytes bytes, double largest_megapixels) {
  if (bytes.empty()) return "is empty, expected an image";
  if (starts_with(bytes, kPng)) return png_fault(bytes, largest_megapixels);
  if (starts_with(bytes, "\xFF\xD8")) return jpeg_fault(bytes, largest_megapixels);
  if (starts_with(bytes, "P5") || starts_with(bytes, "P6")) return pnm_fault(bytes, largest_megapixels);
  return "is not an image that can be read, expected PNG, JPEG or binary PGM";
}

}  // namespace headway::vision
