// A port of the kernel's virtual USB host controller (vhci_hcd) with a UsbDevice in it. The kernel speaks
// USB/IP messages over one end of a socket pair (kernel: Documentation/usb/usbip_protocol.rst); this answers
// at the other.
#pragma once

#include <deque>
#include <functional>
#include <set>

#include "tests/hil/file_descriptor.h"
#include "tests/hil/usb_device.h"

namespace headway::hil {

/// Gives the other side the socket of a device that is being plugged in; it keeps a duplicate.
using Attach = std::function<void(int socket, UsbSpeed speed)>;

/// Port `number` of the kernel, 0..7. Needs modprobe vhci-hcd, and root. Attaching waits up to 5 s for the
/// kernel to be done with what was plugged in before; throws Error where it takes no device.
Attach attach_to_kernel(unsigned number);

class UsbipPort {
 public:
  /// The device must outlive this.
  UsbipPort(UsbDevice& device, Attach attach) : device_(device), attach_(std::move(attach)) {}

  /// Plugs the device in; does nothing if it is. Throws what Attach throws.
  void plug();
  void unplug();

  /// The endpoint (its address, 0x80 for those to the host) stalls until the host clears the halt; 0 stalls
  /// the next control request.
  void stall(std::uint8_t endpoint);

  int descriptor() const { return socket_.number(); }  ///< for poll(); -1 while unplugged
  /// Whether the kernel waits for bulk data that the device does not have yet.
  bool is_waiting() const { return !waiting_.empty(); }
  /// Answers one message of the kernel; call it when descriptor() has something to read.
  void answer_message();
  /// Hands over what the device has to send. Call it after anything that the device was told.
  void send_waiting();

 private:
  struct Transfer {
    std::uint32_t sequence = 0;
    std::uint8_t endpoint = 0;  ///< address
    std::uint32_t length = 0;
    SetupPacket setup;
    Bytes sent;

    bool to_host() const { return (endpoint & 0x80) != 0; }
  };

  bool read_all(std::span<std::uint8_t> into);
  void write_all(ByteSpan bytes);
  void submit(Transfer transfer);
  void unlink(std::uint32_t sequence, std::uint32_t unwanted);
  void control(const Transfer& transfer);
  std::optional<Bytes> control_answer(const SetupPacket& setup, ByteSpan sent);
  void clear_halt(std::uint8_t endpoint);
  void finish(const Transfer& transfer, std::int32_t status, ByteSpan data = {});

  UsbDevice& device_;
  Attach attach_;
  FileDescriptor socket_;
  std::deque<Transfer> waiting_;  ///< bulk transfers to the host that the device has nothing for yet
  std::set<std::uint8_t> stalled_;
};

}  // namespace headway::hil
