// One asynchronous bulk transfer of libusb with its buffer: submitted again and again, owned for all that
// time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/usb_calls.h"

namespace headway::drivers {

class UsbTransfer {
 public:
  /// Who is told, from within UsbCalls::handle_events or control_transfer, that a transfer is back.
  class Owner {
   public:
    virtual void done(UsbTransfer& transfer) noexcept = 0;

   protected:
    ~Owner() = default;
  };
  /// A multiple of every packet size of bulk endpoints up to high speed, so that no packet is too long for
  /// it.
  static constexpr std::size_t kBufferSize = 512;

  /// Throws Error when there is no memory for it.
  UsbTransfer(UsbCalls& usb, libusb_device_handle* handle, std::uint8_t endpoint, Owner& owner);
  /// Must be back by then.
  ~UsbTransfer() { usb_.free_transfer(transfer_); }
  UsbTransfer(const UsbTransfer&) = delete;
  UsbTransfer& operator=(const UsbTransfer&) = delete;

  /// LIBUSB_ERROR_* or 0. A write takes the first `size` bytes of the buffer, a read at most so many.
  int submit(std::size_t size) noexcept;
  /// It comes back all the same, sooner.
  void cancel() noexcept {
    if (under_way_) usb_.cancel_transfer(transfer_);
  }

  bool is_under_way() const noexcept { return under_way_; }
  bool is_read() const noexcept { return (transfer_->endpoint & LIBUSB_ENDPOINT_IN) != 0; }
  libusb_transfer_status status() const noexcept { return transfer_->status; }
  std::span<std::uint8_t> buffer() noexcept { return buffer_; }
  /// What a read has brought.
  std::span<const std::uint8_t> bytes() const noexcept {
    return std::span(buffer_).first(static_cast<std::size_t>(transfer_->actual_length));
  }

 private:
  static void LIBUSB_CALL call_back(libusb_transfer* transfer);

  UsbCalls& usb_;
  Owner& owner_;
  libusb_transfer* transfer_;
  bool under_way_ = false;
  std::array<std::uint8_t, kBufferSize> buffer_{};
};

}  // namespace headway::drivers
