// The functions of libusb that the drivers use, as a table that a test can replace by a scripted one.
#pragma once

#include <cstdint>
#include <span>

#include <libusb-1.0/libusb.h>

#include "hal/time.h"

namespace headway::drivers {

/// Each as the function of libusb 1.0 that bears its name: results below 0 are LIBUSB_ERROR_*. All of one
/// context is called by one thread.
class UsbCalls {
 public:
  virtual ~UsbCalls() = default;

  virtual int init(libusb_context** context) noexcept = 0;
  virtual void exit(libusb_context* context) noexcept = 0;

  virtual ssize_t get_device_list(libusb_context* context, libusb_device*** list) noexcept = 0;
  /// Gives back the list and its references to devices; an open handle keeps its own.
  virtual void free_device_list(libusb_device** list) noexcept = 0;
  virtual libusb_device* get_device(libusb_device_handle* handle) noexcept = 0;
  virtual int get_device_descriptor(libusb_device* device, libusb_device_descriptor* descriptor) noexcept = 0;
  virtual int get_active_config_descriptor(libusb_device* device,
                                           libusb_config_descriptor** config) noexcept = 0;
  virtual void free_config_descriptor(libusb_config_descriptor* config) noexcept = 0;
  virtual int open(libusb_device* device, libusb_device_handle** handle) noexcept = 0;
  virtual void close(libusb_device_handle* handle) noexcept = 0;
  virtual int get_string_descriptor_ascii(libusb_device_handle* handle, std::uint8_t index,
                                          std::span<unsigned char> text) noexcept = 0;

  /// The kernel's driver leaves when the interface is claimed and comes back when it is released.
  virtual int set_auto_detach_kernel_driver(libusb_device_handle* handle, bool enable) noexcept = 0;
  virtual int claim_interface(libusb_device_handle* handle, int interface) noexcept = 0;
  virtual int release_interface(libusb_device_handle* handle, int interface) noexcept = 0;
  virtual int clear_halt(libusb_device_handle* handle, std::uint8_t endpoint) noexcept = 0;
  /// Waits for the answer; calls transfers back meanwhile.
  virtual int control_transfer(libusb_device_handle* handle, std::uint8_t type, std::uint8_t request,
                               std::uint16_t value, std::uint16_t index, std::span<std::uint8_t> data,
                               Duration timeout) noexcept = 0;

  virtual libusb_transfer* alloc_transfer() noexcept = 0;
  virtual void free_transfer(libusb_transfer* transfer) noexcept = 0;
  virtual int submit_transfer(libusb_transfer* transfer) noexcept = 0;
  virtual int cancel_transfer(libusb_transfer* transfer) noexcept = 0;
  /// Waits until something is ready, `bell` is readable or the time is over; then calls back what is done.
  virtual int handle_events(libusb_context* context, int bell, Duration longest) noexcept = 0;

  virtual const char* error_name(int error) const noexcept = 0;
};

/// The library itself.
UsbCalls& libusb() noexcept;

}  // namespace headway::drivers
