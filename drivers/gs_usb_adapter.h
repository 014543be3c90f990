// One USB-CAN adapter of the candleLight kind, found by its serial number and opened through libusb: what
// goes over its control endpoint. It is its owner who moves frames through the bulk endpoints.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "drivers/back_off.h"
#include "drivers/gs_usb_protocol.h"
#include "drivers/usb_calls.h"
#include "hal/can_bus.h"
#include "hal/time.h"

namespace headway::drivers {

struct GsUsbConfig {
  std::string serial{};  ///< as the adapter tells it (lsusb -v: iSerial); empty: the only one plugged in
  unsigned channel = 0;  ///< of adapters with several CAN connectors, from 0
  std::uint32_t bitrate = hal::kCanBitRate;  ///< [bit/s]
  double sample_point = 0.875;               ///< fraction of the bit
  /// A frame that is not on the bus by then is given up, for it would be late: the controller is started
  /// anew.
  Duration echo_timeout = std::chrono::milliseconds(100);
  BackOffConfig retry{};  ///< of finding an adapter that was lost

  /// Throws InputError when no bus could work with these.
  void validate() const;
};

/// Open from construction on, with its controller reset. Destruction resets that again, and nothing ever
/// resets the USB device: an adapter left running, or reset over USB, is hung until it is plugged in anew.
/// All calls by one thread.
///
/// A libusb context of its own: a new one lists what is plugged in now, even where nobody tells of changes (a
/// container, a machine without udev). Where libusb was built with udev it keeps a thread that listens to
/// that.
class GsUsbAdapter {
 public:
  /// Throws InputError when there is no such adapter, or more than one; Error, with what to do, when it may
  /// not be used, is used by another program, does not answer, lacks the channel or cannot keep the bit rate.
  /// Each request may take kAnswerTimeout.
  GsUsbAdapter(UsbCalls& usb, const GsUsbConfig& config);
  ~GsUsbAdapter();
  GsUsbAdapter(const GsUsbAdapter&) = delete;
  GsUsbAdapter& operator=(const GsUsbAdapter&) = delete;

  /// The controller takes part in the bus, or leaves it and forgets the frames it holds. False when the
  /// adapter did not obey.
  bool start() noexcept;
  bool reset() noexcept;
  /// Of both bulk endpoints, after a stall.
  bool clear_halts() noexcept;

  /// What it said of itself when it was opened.
  const gs_usb::DeviceConfig& device() const noexcept { return device_; }
  bool has_clock() const noexcept { return has(gs_usb::kTimestamps); }
  bool tells_state() const noexcept { return has(gs_usb::kTellsState); }
  /// The adapter's clock [us]; nothing when it does not answer.
  std::optional<std::uint32_t> timestamp() noexcept;
  std::optional<gs_usb::ControllerState> controller_state() noexcept;

  libusb_context* context() const noexcept { return context_.get(); }
  libusb_device_handle* handle() const noexcept { return handle_.get(); }
  std::uint8_t endpoint_in() const noexcept { return interface_.in; }
  std::uint8_t endpoint_out() const noexcept { return interface_.out; }

  static constexpr Duration kAnswerTimeout = std::chrono::milliseconds(500);

 private:
  struct Interface {
    std::uint8_t number = 0, in = 0, out = 0;  ///< of the interface and of its bulk endpoints
  };
  struct Exit {
    UsbCalls* usb;
    void operator()(libusb_context* context) const noexcept { usb->exit(context); }
  };
  struct Close {
    UsbCalls* usb;
    void operator()(libusb_device_handle* handle) const noexcept { usb->close(handle); }
  };
  struct Release {
    UsbCalls* usb;
    int interface;
    void operator()(libusb_device_handle* handle) const noexcept {
      usb->release_interface(handle, interface);
    }
  };
  using Context = std::unique_ptr<libusb_context, Exit>;
  using Handle = std::unique_ptr<libusb_device_handle, Close>;
  using Claim = std::unique_ptr<libusb_device_handle, Release>;

  Context new_context();
  Handle find();
  Handle open(libusb_device* device, std::string& serial, std::string& fault);
  Interface bulk_interface();
  Claim claim();
  void set_up();

  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail_request(gs_usb::Request request, int error) const;
  bool has(std::uint32_t feature) const noexcept { return (capabilities_.features & feature) != 0; }
  int ask(gs_usb::Request request, std::uint16_t value, std::span<std::uint8_t> answer) noexcept;
  int tell(gs_usb::Request request, std::uint16_t value, std::span<const std::uint8_t> data) noexcept;
  void must_tell(gs_usb::Request request, std::uint16_t value, std::span<const std::uint8_t> data);
  void must_ask(gs_usb::Request request, std::uint16_t value, std::span<std::uint8_t> answer);

  UsbCalls& usb_;
  GsUsbConfig config_;
  Context context_;
  Handle handle_;
  Interface interface_;
  Claim claim_;
  gs_usb::DeviceConfig device_;
  gs_usb::Capabilities capabilities_;
};

}  // namespace headway::drivers
