#include "drivers/usb_transfer.h"

#include "hal/error.h"

namespace headway::drivers {

UsbTransfer::UsbTransfer(UsbCalls& usb, libusb_device_handle* handle, std::uint8_t endpoint, Owner& owner)
    : usb_(usb), owner_(owner), transfer_(usb.alloc_transfer()) {
  if (transfer_ == nullptr) throw Error("USB transfer: no memory for it; end other programs");
  libusb_fill_bulk_transfer(transfer_, handle, endpoint, buffer_.data(), 0, &UsbTransfer::call_back, this, 0);
}

int UsbTransfer::submit(std::size_t size) noexcept {
  transfer_->length = static_cast<int>(size);
  const int error = usb_.submit_transfer(transfer_);
  under_way_ = error == 0;
  return error;
}

void UsbTransfer::call_back(libusb_transfer* transfer) {
  auto& self = *static_cast<UsbTransfer*>(transfer->user_data);
  self.under_way_ = false;
  self.owner_.done(self);
}

}  // namespace headway::drivers
