// A candleLight USB-CAN adapter with one channel (protocol: kernel, drivers/net/can/usb/gs_usb.c) and a bus
// on which one other node answers every frame with the same data under the next identifier. It has faults on
// demand.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>

#include "hal/clock.h"
#include "tests/hil/usb_device.h"

namespace headway::hil {

/// What the adapter has seen since it was made.
struct GsUsbCounts {
  std::uint64_t sent = 0;  ///< frames that the host put on the bus
  std::uint64_t misused =
      0;  ///< what a real adapter cannot use: frames while it is stopped, of a wrong length or
          ///< channel, or more than its ten slots hold; requests without their data
};

class EmulatedGsUsb final : public UsbDevice {
 public:
  static constexpr std::uint8_t kIn = 0x81, kOut = 0x02;  ///< bulk endpoints

  /// The clock gives the frames' time stamps and must outlive this.
  EmulatedGsUsb(std::string serial, const hal::Clock& clock);

  /// The numbers of the protocol's GET_STATE.
  enum class BusState : std::uint8_t { kActive = 0, kWarning = 1, kPassive = 2, kBusOff = 3 };
  /// One wrong thing in the next packet to the host.
  enum class Fault : std::uint8_t { kNone, kUnknownEcho, kWrongChannel, kWrongDlc, kHalf, kLong, kOverflow };

  void inject(Fault fault) { fault_ = fault; }
  /// Tells the host of a new state in an error frame. Off the bus, nothing sent is echoed until a reset.
  void set_bus_state(BusState state);
  /// While held, nothing goes to the host: its answers come late, all at once.
  void hold(bool held) { held_ = held; }
  /// While deaf, what is sent is never echoed: the other nodes do not acknowledge.
  void set_deaf(bool deaf) { deaf_ = deaf; }
  /// A frame from another node. At most eight bytes count.
  void bus_frame(std::uint32_t id, ByteSpan data);

  const GsUsbCounts& counts() const { return counts_; }

  const UsbDescription& description() const override { return description_; }
  std::optional<Bytes> request(const SetupPacket& setup, ByteSpan sent) override;
  void receive(std::uint8_t endpoint, ByteSpan bytes) override;
  std::optional<Bytes> send(std::uint8_t endpoint, std::size_t room) override;
  void power_on() override;

 private:
  struct Packet {
    std::uint32_t echo = 0, id = 0;
    std::uint8_t dlc = 0;
    std::array<std::uint8_t, 8> data{};
  };

  bool apply(const SetupPacket& setup, ByteSpan sent);
  std::optional<Bytes> tell(const SetupPacket& setup) const;
  std::uint32_t microseconds() const;
  Bytes encode(const Packet& packet, Fault fault) const;

  UsbDescription description_;
  const hal::Clock& clock_;
  bool started_ = false, stamped_ = false, held_ = false, deaf_ = false;
  BusState state_ = BusState::kActive;
  Fault fault_ = Fault::kNone;
  std::deque<Packet> to_host_;
  std::size_t in_flight_ = 0;  ///< frames of the host whose echo it has not got
  GsUsbCounts counts_;
};

}  // namespace headway::hil
