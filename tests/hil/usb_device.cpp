#include "tests/hil/usb_device.h"

namespace headway::hil {
namespace {

// USB 2.0, tables 9-4 and 9-5.
constexpr std::uint8_t kGetStatus = 0, kClearFeature = 1, kSetFeature = 3, kGetDescriptor = 6,
                       kGetConfiguration = 8, kSetConfiguration = 9, kGetInterface = 10, kSetInterface = 11;
constexpr std::uint8_t kDeviceType = 1, kConfigurationType = 2, kStringType = 3;

Bytes string_descriptor(const std::string& text) {
  Bytes bytes{static_cast<std::uint8_t>(2 + 2 * text.size()), kStringType};
  for (char c : text) append_le(bytes, static_cast<std::uint8_t>(c), 2);
  return bytes;
}

std::optional<Bytes> descriptor(const UsbDescription& description, std::uint16_t value) {
  const std::size_t index = value & 0xFF;
  switch (value >> 8) {
    case kDeviceType:
      return description.device;
    case kConfigurationType:
      return description.configuration;
    case kStringType:
      if (index == 0) return Bytes{4, kStringType, 0x09, 0x04};  // languages: English
      if (index > description.strings.size()) return std::nullopt;
      return string_descriptor(description.strings[index - 1]);
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<Bytes> answer_standard_request(const UsbDescription& description, const SetupPacket& setup) {
  switch (setup.request) {
    case kGetDescriptor:
      return descriptor(description, setup.value);
    case kGetStatus:
      return Bytes{0, 0};
    case kGetConfiguration:
      return Bytes{1};
    case kGetInterface:
      return Bytes{0};
    case kClearFeature:
    case kSetFeature:
    case kSetConfiguration:
    case kSetInterface:
      return Bytes{};
    default:
      return std::nullopt;
  }
}

}  // namespace headway::hil
