// What a CANopen node's emergency message is about.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace headway::hal {

/// The name of an emergency error code, or of the narrowest class that the standards give it: CiA 301,
/// "Emergency error code classes" and "Emergency error codes", and of CiA 402 the following error. Empty for
/// codes that they reserve.
constexpr std::string_view name_of_emergency(std::uint16_t code) noexcept {
  struct Class {
    std::uint16_t mask, code;
    std::string_view name;
  };
  // The narrower ones first.
  constexpr std::array kClasses{
      Class{0xFFFF, 0x8110, "CAN overrun, objects lost"},
      Class{0xFFFF, 0x8120, "CAN in error passive mode"},
      Class{0xFFFF, 0x8130, "life guard or heartbeat error"},
      Class{0xFFFF, 0x8140, "recovered from bus off"},
      Class{0xFFFF, 0x8150, "CAN-ID collision"},
      Class{0xFFFF, 0x8210, "PDO not processed due to length error"},
      Class{0xFFFF, 0x8220, "PDO length exceeded"},
      Class{0xFFFF, 0x8230, "DAM MPDO not processed, destination object not available"},
      Class{0xFFFF, 0x8240, "unexpected SYNC data length"},
      Class{0xFFFF, 0x8250, "RPDO timeout"},
      Class{0xFFFF, 0x8611, "following error"},
      Class{0xFF00, 0x0000, "error reset or no error"},
      Class{0xFF00, 0x1000, "generic error"},
      Class{0xFF00, 0x2100, "current, input side"},
      Class{0xFF00, 0x2200, "current inside the device"},
      Class{0xFF00, 0x2300, "current, output side"},
      Class{0xF000, 0x2000, "current"},
      Class{0xFF00, 0x3100, "mains voltage"},
      Class{0xFF00, 0x3200, "voltage inside the device"},
      Class{0xFF00, 0x3300, "output voltage"},
      Class{0xF000, 0x3000, "voltage"},
      Class{0xFF00, 0x4100, "ambient temperature"},
      Class{0xFF00, 0x4200, "device temperature"},
      Class{0xF000, 0x4000, "temperature"},
      Class{0xFF00, 0x5000, "device hardware"},
      Class{0xFF00, 0x6100, "internal software"},
      Class{0xFF00, 0x6200, "user software"},
      Class{0xFF00, 0x6300, "data set"},
      Class{0xF000, 0x6000, "device software"},
      Class{0xFF00, 0x7000, "additional modules"},
      Class{0xFF00, 0x8100, "communication"},
      Class{0xFF00, 0x8200, "protocol error"},
      Class{0xF000, 0x8000, "monitoring"},
      Class{0xFF00, 0x9000, "external error"},
      Class{0xFF00, 0xF000, "additional functions"},
      Class{0xFF00, 0xFF00, "device specific"},
  };
  for (const Class& c : kClasses)
    if ((code & c.mask) == c.code) return c.name;
  return {};
}

}  // namespace headway::hal
