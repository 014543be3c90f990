// A USB device as its firmware sees it: what it tells about itself, control requests, bulk endpoints.
// Emulated devices derive from it; UsbipPort plugs them into the kernel.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/hil/bytes.h"

namespace headway::hil {

/// USB 2.0, table 9-2.
struct SetupPacket {
  std::uint8_t request_type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;

  bool to_host() const { return (request_type & 0x80) != 0; }
  bool is_standard() const { return (request_type & 0x60) == 0; }
};

enum class UsbSpeed : std::uint8_t { kFull = 2, kHigh = 3 };  ///< the kernel's numbers (linux/usb/ch9.h)

struct UsbDescription {
  UsbSpeed speed = UsbSpeed::kHigh;
  Bytes device, configuration;       ///< descriptors, USB 2.0, 9.6
  std::vector<std::string> strings;  ///< from index 1, ASCII
};

class UsbDevice {
 public:
  virtual ~UsbDevice() = default;
  virtual const UsbDescription& description() const = 0;
  /// A class's or vendor's control request, with the data sent along. Its answer, empty where none goes to
  /// the host; nullopt stalls.
  virtual std::optional<Bytes> request(const SetupPacket& setup, ByteSpan sent) = 0;
  /// One bulk transfer from the host.
  virtual void receive(std::uint8_t endpoint, ByteSpan bytes) = 0;
  /// At most `room` bytes for a bulk transfer to the host; nullopt: nothing yet.
  virtual std::optional<Bytes> send(std::uint8_t endpoint, std::size_t room) = 0;
  /// The host has cleared a halt of this endpoint: its transfers begin anew.
  virtual void halt_cleared(std::uint8_t /*endpoint*/) {}
  /// Plugged in: as after power has come.
  virtual void power_on() {}
};

/// What any device answers to the standard requests that concern it as a whole (USB 2.0, 9.4); nullopt
/// stalls.
std::optional<Bytes> answer_standard_request(const UsbDescription& description, const SetupPacket& setup);

}  // namespace headway::hil
