// A CAN bus behind a USB-CAN adapter of the candleLight kind (candleLight, CANable), in user space through
// libusb; an adapter that is unplugged is looked for by its serial number and opened again.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "drivers/back_off.h"
#include "drivers/can_mailbox.h"
#include "drivers/gs_usb_adapter.h"
#include "drivers/gs_usb_link.h"
#include "drivers/usb_calls.h"
#include "drivers/wake_up.h"
#include "hal/can_bus.h"
#include "hal/clock.h"

namespace headway::drivers {

/// Who may call what: one thread, the bus loop's, sends and receives; another calls serve() over and over and
/// does all that waits or uses the heap; state() and stats() are anybody's. Construction and destruction
/// happen while neither thread is at it.
///
/// A frame counts as sent once the adapter says that it was on the bus. Ten may be under way: then send()
/// refuses, as it does while the adapter is away. A frame that is not on the bus after
/// GsUsbConfig::echo_timeout is given up with all that are under way, and the controller is started anew.
/// Stamps are the adapter's where it has a clock, to about half a millisecond; else when the frame came in.
class GsUsbBus final : public hal::CanBus {
 public:
  /// Opens the adapter. Throws InputError as GsUsbConfig::validate, and what GsUsbAdapter throws. Clock and
  /// calls must outlive the bus.
  GsUsbBus(const GsUsbConfig& config, hal::Clock& clock, UsbCalls& usb = libusb());
  ~GsUsbBus() override;

  /// Moves frames between the adapter and the bus loop, and (re)opens it, for `longest`. An opening under way
  /// is finished first: with an adapter that does not answer that takes GsUsbAdapter::kAnswerTimeout more.
  void serve(Duration longest) noexcept;

  /// What the adapter said of itself when the bus was constructed.
  const gs_usb::DeviceConfig& device() const noexcept { return device_; }

  bool send(const hal::CanFrame& frame) noexcept override;
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override { return mailbox_.receive(into); }
  hal::CanBusState state() const noexcept override { return mailbox_.state(); }
  /// `lost` counts overflows that the adapter told of, not the frames that each cost.
  hal::CanBusStats stats() const noexcept override { return mailbox_.stats(); }

 private:
  void serve_link(Duration longest) noexcept;
  void open_again() noexcept;

  GsUsbConfig config_;
  hal::Clock& clock_;
  UsbCalls& usb_;
  CanMailbox mailbox_;
  WakeUp bell_;  ///< rung for every frame that is to be sent
  std::unique_ptr<GsUsbLink> link_;
  gs_usb::DeviceConfig device_;
  Time opened_{};
  BackOff retry_;
};

}  // namespace headway::drivers
