#include "tests/hil/uvc_descriptors.h"

#include <algorithm>
#include <string_view>

namespace headway::hil::uvc {
namespace {

constexpr std::uint8_t kVideoClass = 0x0E, kVideoControl = 1, kVideoStreaming = 2, kVideoCollection = 3;
constexpr std::uint8_t kClassInterface = 0x24;
// Table A-6.
constexpr std::uint8_t kFormatUncompressed = 4, kFrameUncompressed = 5, kFormatMjpeg = 6, kFrameMjpeg = 7;

const Bytes kDevice{18, 1, 0x00, 0x02, 0xEF, 2, 1, 64, 0x50, 0x1d, 0x77, 0x77, 0, 0, 1, 2, 3, 1};

void append(Bytes& bytes, const Bytes& more) { bytes.insert(bytes.end(), more.begin(), more.end()); }

// Section 3.7.2: camera terminal -> processing unit -> output terminal.
Bytes control_descriptors() {
  Bytes parts;
  append(parts, {18, kClassInterface, 2, kCameraTerminal, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0x0A, 0,
                 0});  // exposure: mode and absolute time
  append(parts, {11, kClassInterface, 5, kProcessingUnit, kCameraTerminal, 0, 0, 2, 0x41, 0x12,
                 0});  // brightness, gain, white balance and whether that is automatic
  append(parts, {9, kClassInterface, 3, kOutputTerminal, 0x01, 0x01, 0, kProcessingUnit, 0});

  Bytes header{13, kClassInterface, 1, 0x00, 0x01};
  append_le(header, static_cast<std::uint32_t>(13 + parts.size()), 2);
  append_le(header, 1'000'000, 4);  // clock, Hz
  append(header, {1, kStreamingInterface});
  append(header, parts);
  return header;
}

// Payload specifications: "Uncompressed", 3.1.1, and "Motion-JPEG", 3.1.1. The GUIDs begin with the FourCC;
// that of 16-bit depth is the one of depth cameras with an INVZ stream.
Bytes format_descriptor(EmulatedUvc::Config::Format format) {
  using Format = EmulatedUvc::Config::Format;
  if (format == Format::kMjpeg) return {11, kClassInterface, kFormatMjpeg, 1, 1, 0, 1, 0, 0, 0, 0};
  const std::string_view code = format == Format::kGrey ? "Y800" : format == Format::kYuyv ? "YUY2" : "INVZ";
  Bytes bytes{27, kClassInterface, kFormatUncompressed, 1, 1};
  for (char c : code) bytes.push_back(static_cast<std::uint8_t>(c));
  if (format == Format::kZ16)
    append(bytes, {0x90, 0x2D, 0x58, 0x4A, 0x92, 0x0B, 0x77, 0x3F, 0x1F, 0x2C, 0x55, 0x6B});
  else
    append(bytes, {0, 0, 0x10, 0, 0x80, 0, 0, 0xAA, 0, 0x38, 0x9B, 0x71});
  append(bytes, {static_cast<std::uint8_t>(format == Format::kGrey ? 8 : 16), 1, 0, 0, 0, 0});
  return bytes;
}

Bytes frame_descriptor(const EmulatedUvc::Config& config) {
  const auto bits_per_second = [&](std::uint32_t interval) {
    return static_cast<std::uint32_t>(std::uint64_t{config.frame_size()} * 8 * 10'000'000 / interval);
  };
  const auto [shortest, longest] = std::minmax_element(kIntervals.begin(), kIntervals.end());
  const bool jpeg = config.format == EmulatedUvc::Config::Format::kMjpeg;
  Bytes bytes{static_cast<std::uint8_t>(26 + 4 * kIntervals.size()), kClassInterface,
              jpeg ? kFrameMjpeg : kFrameUncompressed, 1, 0};
  append_le(bytes, config.width, 2);
  append_le(bytes, config.height, 2);
  append_le(bytes, bits_per_second(*longest), 4);
  append_le(bytes, bits_per_second(*shortest), 4);
  append_le(bytes, config.frame_size(), 4);
  append_le(bytes, kIntervals.front(), 4);
  bytes.push_back(static_cast<std::uint8_t>(kIntervals.size()));
  for (std::uint32_t interval : kIntervals) append_le(bytes, interval, 4);
  return bytes;
}

// Section 3.9.2.
Bytes streaming_descriptors(const EmulatedUvc::Config& config) {
  Bytes parts = format_descriptor(config.format);
  append(parts, frame_descriptor(config));

  Bytes header{14, kClassInterface, 1, 1};
  append_le(header, static_cast<std::uint32_t>(14 + parts.size()), 2);
  append(header, {EmulatedUvc::kIn, 0, kOutputTerminal, 0, 0, 0, 1, 0});
  append(header, parts);
  return header;
}

Bytes configuration(const EmulatedUvc::Config& config) {
  Bytes parts{8, 0x0B, kControlInterface, 2, kVideoClass, kVideoCollection, 0, 0};
  append(parts, {9, 4, kControlInterface, 0, 0, kVideoClass, kVideoControl, 0, 0});
  append(parts, control_descriptors());
  append(parts, {9, 4, kStreamingInterface, 0, 1, kVideoClass, kVideoStreaming, 0, 0});
  append(parts, streaming_descriptors(config));
  append(parts, {7, 5, EmulatedUvc::kIn, 2, 0x00, 0x02, 0});  // bulk, 512 bytes

  Bytes bytes{9, 2};
  append_le(bytes, static_cast<std::uint32_t>(9 + parts.size()), 2);
  append(bytes, {2, 1, 0, 0x80, 250});  // two interfaces, from the bus 500 mA
  append(bytes, parts);
  return bytes;
}

}  // namespace

UsbDescription describe(const EmulatedUvc::Config& config) {
  return {.speed = UsbSpeed::kHigh,
          .device = kDevice,
          .configuration = configuration(config),
          .strings = {"Headway", "emulated camera", config.serial}};
}

}  // namespace headway::hil::uvc
