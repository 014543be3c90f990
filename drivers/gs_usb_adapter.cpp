#include "drivers/gs_usb_adapter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::drivers {

using gs_usb::Request;

namespace {

/// What is plugged in, by one context; gives the list back.
class DeviceList {
 public:
  DeviceList(UsbCalls& usb, libusb_context* context)
      : usb_(usb), count_(usb.get_device_list(context, &list_)) {}
  ~DeviceList() {
    if (count_ >= 0) usb_.free_device_list(list_);
  }
  DeviceList(const DeviceList&) = delete;
  DeviceList& operator=(const DeviceList&) = delete;

  std::span<libusb_device*> devices() const {
    return {list_, static_cast<std::size_t>(std::max<ssize_t>(count_, 0))};
  }

 private:
  UsbCalls& usb_;
  libusb_device** list_ = nullptr;
  ssize_t count_;
};

bool is_adapter(const libusb_device_descriptor& d) {
  return std::any_of(gs_usb::kProducts.begin(), gs_usb::kProducts.end(), [&](const gs_usb::Product& p) {
    return p.vendor == d.idVendor && p.product == d.idProduct;
  });
}

bool is_bulk(const libusb_endpoint_descriptor& e) {
  return (e.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) == LIBUSB_TRANSFER_TYPE_BULK;
}

const char* remedy(int error) {
  switch (error) {
    case LIBUSB_ERROR_ACCESS:
      return "this user may not use it: install config/udev/60-headway.rules and plug it in anew";
    case LIBUSB_ERROR_BUSY:
      return "another program uses it: end that";
    case LIBUSB_ERROR_NO_DEVICE:
      return "it was unplugged";
    default:
      return "unplug it and plug it in anew";
  }
}

void require(bool fulfilled, const std::string& what) {
  if (!fulfilled) throw InputError("USB-CAN adapter: " + what);
}

std::string about(const GsUsbConfig& config, const std::string& what) {
  return config.serial.empty() ? "USB-CAN adapter: " + what
                               : fmt::format("USB-CAN adapter '{}': {}", config.serial, what);
}

}  // namespace

void GsUsbConfig::validate() const {
  require(channel <= 255, fmt::format("channel: {}, expected 0 to 255", channel));
  require(bitrate >= 10'000 && bitrate <= 1'000'000,
          fmt::format("bitrate: {} bit/s, expected 10000 to 1000000", bitrate));
  require(sample_point >= 0.5 && sample_point <= 0.95,
          fmt::format("sample_point: {}, expected 0.5 to 0.95", sample_point));
  require(echo_timeout >= std::chrono::milliseconds(10),
          fmt::format("echo_timeout: {} s, expected at least 0.01 s", to_seconds(echo_timeout)));
  require(
      retry.is_sound(),
      fmt::format("retry: first {} s, longest {} s, expected 0.001 s to an hour, and the longest no shorter",
                  to_seconds(retry.first), to_seconds(retry.longest)));
}

GsUsbAdapter::GsUsbAdapter(UsbCalls& usb, const GsUsbConfig& config)
    : usb_(usb),
      config_(config),
      context_(new_context()),
      handle_(find()),
      interface_(bulk_interface()),
      claim_(claim()) {
  set_up();
}

GsUsbAdapter::~GsUsbAdapter() { reset(); }

void GsUsbAdapter::fail(const std::string& what) const { throw Error(about(config_, what)); }

GsUsbAdapter::Context GsUsbAdapter::new_context() {
  libusb_context* context = nullptr;
  if (const int error = usb_.init(&context); error < 0) {
    fail(fmt::format("libusb does not start ({}), expected USB on this machine; is /dev/bus/usb there?",
                     usb_.error_name(error)));
  }
  return Context(context, Exit{&usb_});
}

GsUsbAdapter::Handle GsUsbAdapter::open(libusb_device* device, std::string& serial, std::string& fault) {
  libusb_device_descriptor d{};
  if (usb_.get_device_descriptor(device, &d) < 0 || !is_adapter(d)) return Handle(nullptr, Close{&usb_});
  libusb_device_handle* opened = nullptr;
  if (const int error = usb_.open(device, &opened); error < 0) {
    fault = fmt::format("; one of {:04x}:{:04x} could not be asked ({}): {}", d.idVendor, d.idProduct,
                        usb_.error_name(error), remedy(error));
    return Handle(nullptr, Close{&usb_});
  }
  Handle handle(opened, Close{&usb_});
  std::array<unsigned char, 128> text{};
  const int length = usb_.get_string_descriptor_ascii(opened, d.iSerialNumber, text);
  if (length > 0) serial.assign(text.begin(), text.begin() + length);
  return handle;
}

GsUsbAdapter::Handle GsUsbAdapter::find() {
  const DeviceList list(usb_, context_.get());
  std::string seen, fault;
  Handle found(nullptr, Close{&usb_});
  bool several = false;
  for (libusb_device* device : list.devices()) {
    std::string serial;
    Handle handle = open(device, serial, fault);
    if (!handle) continue;
    seen += (seen.empty() ? "'" : ", '") + serial + "'";
    if (!config_.serial.empty() && serial != config_.serial) continue;
    several = several || found;
    found = std::move(handle);
  }
  if (several) {
    throw InputError(
        fmt::format("USB-CAN adapter: {} fit serial '{}', expected one: name the serial of one of them", seen,
                    config_.serial));
  }
  if (!found) {
    const std::string what =
        fmt::format("is not there, expected {} among the candleLight-type adapters plugged in: {}{}",
                    config_.serial.empty() ? "one" : "it", seen.empty() ? "none" : seen, fault);
    if (!fault.empty()) fail(what);  // it may be the one that does not let itself be asked
    throw InputError(about(config_, what));
  }
  return found;
}

GsUsbAdapter::Interface GsUsbAdapter::bulk_interface() {
  libusb_config_descriptor* got = nullptr;
  if (const int error = usb_.get_active_config_descriptor(usb_.get_device(handle_.get()), &got); error < 0) {
    fail(fmt::format("does not tell its endpoints ({}): {}", usb_.error_name(error), remedy(error)));
  }
  const auto give_back = [this](libusb_config_descriptor* c) { usb_.free_config_descriptor(c); };
  const std::unique_ptr<libusb_config_descriptor, decltype(give_back)> config(got, give_back);
  for (const libusb_interface& interface : std::span(config->interface, config->bNumInterfaces)) {
    if (interface.num_altsetting < 1) continue;
    const libusb_interface_descriptor& setting = interface.altsetting[0];
    Interface found{.number = setting.bInterfaceNumber};
    for (const libusb_endpoint_descriptor& e : std::span(setting.endpoint, setting.bNumEndpoints)) {
      if (!is_bulk(e)) continue;
      ((e.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0 ? found.in : found.out) = e.bEndpointAddress;
    }
    if (found.in != 0 && found.out != 0) return found;
  }
  fail("has no bulk endpoints, expected one in and one out; its firmware is not candleLight's");
}

GsUsbAdapter::Claim GsUsbAdapter::claim() {
  // Where the kernel has no driver to detach, or cannot, claiming tells.
  usb_.set_auto_detach_kernel_driver(handle_.get(), true);
  if (const int error = usb_.claim_interface(handle_.get(), interface_.number); error < 0) {
    fail(fmt::format("cannot be claimed ({}): {}", usb_.error_name(error), remedy(error)));
  }
  return Claim(handle_.get(), Release{&usb_, interface_.number});
}

void GsUsbAdapter::set_up() {
  must_tell(Request::kHostFormat, 1, gs_usb::pack_host_format());
  std::array<std::uint8_t, gs_usb::DeviceConfig::kSize> device{};
  must_ask(Request::kDeviceConfig, 1, device);
  device_ = gs_usb::DeviceConfig::unpack(device);
  if (config_.channel >= device_.channels) {
    throw InputError(fmt::format("USB-CAN adapter '{}': channel: {}, expected 0 to {}", config_.serial,
                                 config_.channel, device_.channels - 1));
  }
  const auto channel = static_cast<std::uint16_t>(config_.channel);
  std::array<std::uint8_t, gs_usb::Capabilities::kSize> capabilities{};
  must_ask(Request::kBitTimingLimits, channel, capabilities);
  capabilities_ = gs_usb::Capabilities::unpack(capabilities);
  const auto timing =
      find_bit_timing(capabilities_.limits, capabilities_.clock_hz, config_.bitrate, config_.sample_point);
  if (!timing) {
    throw InputError(
        fmt::format("USB-CAN adapter '{}': bitrate: {} bit/s cannot be made of its clock of {} Hz, expected"
                    " one that can",
                    config_.serial, config_.bitrate, capabilities_.clock_hz));
  }
  must_tell(Request::kMode, channel, gs_usb::pack_mode(false, 0));
  must_tell(Request::kBitTiming, channel, gs_usb::pack(*timing));
}

bool GsUsbAdapter::start() noexcept {
  const std::uint32_t flags = has_clock() ? gs_usb::kTimestamps : 0;
  return tell(Request::kMode, static_cast<std::uint16_t>(config_.channel), gs_usb::pack_mode(true, flags)) >=
         0;
}

bool GsUsbAdapter::reset() noexcept {
  return tell(Request::kMode, static_cast<std::uint16_t>(config_.channel), gs_usb::pack_mode(false, 0)) >= 0;
}

bool GsUsbAdapter::clear_halts() noexcept {
  const bool in = usb_.clear_halt(handle_.get(), interface_.in) >= 0;
  return usb_.clear_halt(handle_.get(), interface_.out) >= 0 && in;
}

std::optional<std::uint32_t> GsUsbAdapter::timestamp() noexcept {
  std::array<std::uint8_t, 4> answer{};
  if (ask(Request::kTimestamp, static_cast<std::uint16_t>(config_.channel), answer) < 0) return std::nullopt;
  return gs_usb::unpack_timestamp(answer);
}

std::optional<gs_usb::ControllerState> GsUsbAdapter::controller_state() noexcept {
  std::array<std::uint8_t, gs_usb::ControllerState::kSize> answer{};
  if (ask(Request::kState, static_cast<std::uint16_t>(config_.channel), answer) < 0) return std::nullopt;
  return gs_usb::ControllerState::unpack(answer);
}

int GsUsbAdapter::ask(Request request, std::uint16_t value, std::span<std::uint8_t> answer) noexcept {
  const int got = usb_.control_transfer(handle_.get(), gs_usb::kIn, static_cast<std::uint8_t>(request), value,
                                        interface_.number, answer, kAnswerTimeout);
  return got >= 0 && static_cast<std::size_t>(got) != answer.size() ? LIBUSB_ERROR_IO : got;
}

int GsUsbAdapter::tell(Request request, std::uint16_t value, std::span<const std::uint8_t> data) noexcept {
  std::array<std::uint8_t, 32> bytes{};  // libusb takes what it only reads as if it would write it
  std::copy(data.begin(), data.end(), bytes.begin());
  const int got =
      usb_.control_transfer(handle_.get(), gs_usb::kOut, static_cast<std::uint8_t>(request), value,
                            interface_.number, std::span(bytes).first(data.size()), kAnswerTimeout);
  return got >= 0 && static_cast<std::size_t>(got) != data.size() ? LIBUSB_ERROR_IO : got;
}

void GsUsbAdapter::must_tell(Request request, std::uint16_t value, std::span<const std::uint8_t> data) {
  if (const int error = tell(request, value, data); error < 0) fail_request(request, error);
}

void GsUsbAdapter::must_ask(Request request, std::uint16_t value, std::span<std::uint8_t> answer) {
  if (const int error = ask(request, value, answer); error < 0) fail_request(request, error);
}

void GsUsbAdapter::fail_request(Request request, int error) const {
  fail(fmt::format("does not answer request {} as a candleLight does ({}): {}", static_cast<int>(request),
                   usb_.error_name(error), remedy(error)));
}

}  // namespace headway::drivers
