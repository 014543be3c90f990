#include "drivers/usb_calls.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include <poll.h>

namespace headway::drivers {

namespace {

constexpr std::int64_t kNanoseconds = 1'000'000'000;

/// More descriptors than one context has: its own two or three, and one of each open adapter.
constexpr std::size_t kDescriptors = 16;

class Libusb final : public UsbCalls {
 public:
  int init(libusb_context** context) noexcept override { return libusb_init(context); }
  void exit(libusb_context* context) noexcept override { libusb_exit(context); }

  ssize_t get_device_list(libusb_context* context, libusb_device*** list) noexcept override {
    return libusb_get_device_list(context, list);
  }
  void free_device_list(libusb_device** list) noexcept override { libusb_free_device_list(list, 1); }
  libusb_device* get_device(libusb_device_handle* handle) noexcept override {
    return libusb_get_device(handle);
  }
  int get_device_descriptor(libusb_device* device, libusb_device_descriptor* descriptor) noexcept override {
    return libusb_get_device_descriptor(device, descriptor);
  }
  int get_active_config_descriptor(libusb_device* device,
                                   libusb_config_descriptor** config) noexcept override {
    return libusb_get_active_config_descriptor(device, config);
  }
  void free_config_descriptor(libusb_config_descriptor* config) noexcept override {
    libusb_free_config_descriptor(config);
  }
  int open(libusb_device* device, libusb_device_handle** handle) noexcept override {
    return libusb_open(device, handle);
  }
  void close(libusb_device_handle* handle) noexcept override { libusb_close(handle); }
  int get_string_descriptor_ascii(libusb_device_handle* handle, std::uint8_t index,
                                  std::span<unsigned char> text) noexcept override {
    return libusb_get_string_descriptor_ascii(handle, index, text.data(), static_cast<int>(text.size()));
  }

  int set_auto_detach_kernel_driver(libusb_device_handle* handle, bool enable) noexcept override {
    return libusb_set_auto_detach_kernel_driver(handle, enable ? 1 : 0);
  }
  int claim_interface(libusb_device_handle* handle, int interface) noexcept override {
    return libusb_claim_interface(handle, interface);
  }
  int release_interface(libusb_device_handle* handle, int interface) noexcept override {
    return libusb_release_interface(handle, interface);
  }
  int clear_halt(libusb_device_handle* handle, std::uint8_t endpoint) noexcept override {
    return libusb_clear_halt(handle, endpoint);
  }
  int control_transfer(libusb_device_handle* handle, std::uint8_t type, std::uint8_t request,
                       std::uint16_t value, std::uint16_t index, std::span<std::uint8_t> data,
                       Duration timeout) noexcept override {
    const auto ms = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
    return libusb_control_transfer(handle, type, request, value, index, data.data(),
                                   static_cast<std::uint16_t>(data.size()), static_cast<unsigned>(ms));
  }

  libusb_transfer* alloc_transfer() noexcept override { return libusb_alloc_transfer(0); }
  void free_transfer(libusb_transfer* transfer) noexcept override { libusb_free_transfer(transfer); }
  int submit_transfer(libusb_transfer* transfer) noexcept override {
    return libusb_submit_transfer(transfer);
  }
  int cancel_transfer(libusb_transfer* transfer) noexcept override {
    return libusb_cancel_transfer(transfer);
  }

  // libusb can wait by itself, but then no bell wakes it that another thread may ring without taking a lock.
  int handle_events(libusb_context* context, int bell, Duration longest) noexcept override {
    std::array<pollfd, kDescriptors> waited_for{{{bell, POLLIN, 0}}};
    nfds_t n = 1;
    if (const libusb_pollfd** theirs = libusb_get_pollfds(context)) {
      for (const libusb_pollfd** p = theirs; *p != nullptr && n < kDescriptors; ++p) {
        waited_for[n++] = {(*p)->fd, (*p)->events, 0};
      }
      libusb_free_pollfds(theirs);
    }
    const std::int64_t ns = std::max<std::int64_t>(longest.count(), 0);
    const timespec time{.tv_sec = static_cast<time_t>(ns / kNanoseconds), .tv_nsec = ns % kNanoseconds};
    ppoll(waited_for.data(), n, &time, nullptr);
    timeval none{};
    return libusb_handle_events_timeout_completed(context, &none, nullptr);
  }

  const char* error_name(int error) const noexcept override { return libusb_error_name(error); }
};

}  // namespace

UsbCalls& libusb() noexcept {
  static Libusb calls;
  return calls;
}

}  // namespace headway::drivers
