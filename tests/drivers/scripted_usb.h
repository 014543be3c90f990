// libusb as a test holds it in its hands: adapters are plugged in and out, time stands still but for waiting,
// and all that is opened, listed or allocated is counted until it is given back.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include <poll.h>

#include "drivers/usb_calls.h"
#include "hal/clock.h"
#include "tests/drivers/scripted_adapter.h"

// libusb only declares these.
struct libusb_device {
  headway::drivers::testing::ScriptedAdapter* adapter;
  int plugging;  ///< which time it was plugged in
};
struct libusb_context {
  std::deque<libusb_device> devices;  ///< found when the context was made: nobody tells of changes
};
struct libusb_device_handle {
  libusb_device* device;
  bool is_claimed = false;
};

namespace headway::drivers::testing {

class ScriptedUsb final : public UsbCalls {
 public:
  explicit ScriptedUsb(hal::ManualClock& clock) : clock_(clock) {}

  void plug(ScriptedAdapter& adapter) {
    ++pluggings_;
    plugged_.push_back({&adapter, pluggings_});
    adapter.outbox.clear();
    adapter.seen.is_started = false;
  }
  void unplug(ScriptedAdapter& adapter) {
    std::erase_if(plugged_, [&](const libusb_device& d) { return d.adapter == &adapter; });
  }

  /// The adapter is unplugged by itself within the call that makes this zero.
  int calls_until_unplugged = -1;
  /// Times at which somebody looked for adapters.
  std::vector<Time> searches;
  bool fails_to_start = false, has_no_memory = false;
  std::function<void()> while_waiting;   ///< what another thread does then, once
  std::function<void()> as_time_passes;  ///< what it does every 5 ms
  int interruptions = 0;                 ///< of waiting by a signal, how many more
  bool waits_truly = false;              ///< for 1 ms or the bell, where threads are what is tested

  /// What was taken and not given back.
  struct Held {
    int contexts = 0, lists = 0, configs = 0, handles = 0, claims = 0, transfers = 0, under_way = 0;
    bool operator==(const Held&) const = default;
  };
  Held held() const {
    Held h = held_;
    h.under_way = static_cast<int>(under_way_.size());
    return h;
  }

  /// Counts no longer what a bus rightly kept, because its transfers never came back.
  void forget() {
    held_ = {};
    under_way_.clear();
  }

  int init(libusb_context** context) noexcept override {
    count();
    if (fails_to_start) return LIBUSB_ERROR_OTHER;
    searches.push_back(clock_.now());
    *context = new libusb_context{{plugged_.begin(), plugged_.end()}};
    ++held_.contexts;
    return 0;
  }
  void exit(libusb_context* context) noexcept override {
    delete context;
    --held_.contexts;
  }
  ssize_t get_device_list(libusb_context* context, libusb_device*** list) noexcept override {
    count();
    *list = new libusb_device*[context->devices.size() + 1];
    std::transform(context->devices.begin(), context->devices.end(), *list,
                   [](libusb_device& d) { return &d; });
    ++held_.lists;
    return static_cast<ssize_t>(context->devices.size());
  }
  void free_device_list(libusb_device** list) noexcept override {
    delete[] list;
    --held_.lists;
  }
  libusb_device* get_device(libusb_device_handle* handle) noexcept override { return handle->device; }
  int get_device_descriptor(libusb_device* device, libusb_device_descriptor* d) noexcept override {
    count();
    *d = {};
    d->idVendor = device->adapter->vendor;
    d->idProduct = device->adapter->product;
    d->iSerialNumber = 3;
    return 0;
  }
  int get_active_config_descriptor(libusb_device* device,
                                   libusb_config_descriptor** config) noexcept override {
    count();
    if (!is_there(device)) return LIBUSB_ERROR_NO_DEVICE;
    auto* made = new Config(*device->adapter);
    ++held_.configs;
    *config = made;
    return 0;
  }
  void free_config_descriptor(libusb_config_descriptor* config) noexcept override {
    delete static_cast<Config*>(config);
    --held_.configs;
  }
  int open(libusb_device* device, libusb_device_handle** handle) noexcept override {
    count();
    if (!is_there(device)) return LIBUSB_ERROR_NO_DEVICE;
    if (device->adapter->is_denied) return LIBUSB_ERROR_ACCESS;
    *handle = new libusb_device_handle{device};
    ++held_.handles;
    return 0;
  }
  void close(libusb_device_handle* handle) noexcept override {
    delete handle;
    --held_.handles;
  }
  int get_string_descriptor_ascii(libusb_device_handle* handle, std::uint8_t index,
                                  std::span<unsigned char> text) noexcept override {
    count();
    if (!is_there(handle->device)) return LIBUSB_ERROR_NO_DEVICE;
    if (index != 3) return LIBUSB_ERROR_PIPE;
    const std::string& serial = handle->device->adapter->serial;
    std::copy(serial.begin(), serial.end(), text.begin());
    return static_cast<int>(serial.size());
  }
  int set_auto_detach_kernel_driver(libusb_device_handle*, bool enable) noexcept override {
    count();
    detaches_ = enable;
    return 0;
  }
  int claim_interface(libusb_device_handle* handle, int interface) noexcept override {
    count();
    if (!is_there(handle->device)) return LIBUSB_ERROR_NO_DEVICE;
    const ScriptedAdapter& adapter = *handle->device->adapter;
    if (adapter.is_claimed || !detaches_) return LIBUSB_ERROR_BUSY;
    if (interface != adapter.interface) return LIBUSB_ERROR_NOT_FOUND;
    handle->is_claimed = true;
    ++held_.claims;
    return 0;
  }
  int release_interface(libusb_device_handle* handle, int) noexcept override {
    handle->is_claimed = false;
    --held_.claims;
    return 0;
  }
  int clear_halt(libusb_device_handle* handle, std::uint8_t endpoint) noexcept override {
    count();
    if (!is_there(handle->device)) return LIBUSB_ERROR_NO_DEVICE;
    ScriptedAdapter& adapter = *handle->device->adapter;
    if (endpoint != adapter.endpoint_in && endpoint != adapter.endpoint_out) return LIBUSB_ERROR_NOT_FOUND;
    if (!under_way_.empty()) return LIBUSB_ERROR_BUSY;  // the kernel's rule
    ++adapter.seen.halts_cleared;
    return 0;
  }
  int control_transfer(libusb_device_handle* handle, std::uint8_t type, std::uint8_t request,
                       std::uint16_t value, std::uint16_t index, std::span<std::uint8_t> data,
                       Duration timeout) noexcept override {
    count();
    deliver();
    if (!is_there(handle->device)) return LIBUSB_ERROR_NO_DEVICE;
    ScriptedAdapter& adapter = *handle->device->adapter;
    if (adapter.is_mute || adapter.answer_takes > timeout) {
      pass(timeout);
      return LIBUSB_ERROR_TIMEOUT;
    }
    if (!handle->is_claimed || index != adapter.interface) return LIBUSB_ERROR_PIPE;
    pass(adapter.answer_takes / 2);
    const int result = answer(adapter, type, request, value, data);
    pass(adapter.answer_takes / 2);
    return result;
  }

  libusb_transfer* alloc_transfer() noexcept override {
    if (has_no_memory && held_.transfers >= 5) return nullptr;
    ++held_.transfers;
    return new libusb_transfer{};
  }
  void free_transfer(libusb_transfer* transfer) noexcept override {
    delete transfer;
    --held_.transfers;
  }
  int submit_transfer(libusb_transfer* transfer) noexcept override {
    count();
    if (!is_there(transfer->dev_handle->device)) return LIBUSB_ERROR_NO_DEVICE;
    under_way_.push_back(transfer);
    return 0;
  }
  int cancel_transfer(libusb_transfer* transfer) noexcept override {
    cancelled_.insert(transfer);
    return 0;
  }
  int handle_events(libusb_context*, int bell, Duration longest) noexcept override {
    count();
    if (interruptions > 0) {
      --interruptions;
      return LIBUSB_ERROR_INTERRUPTED;
    }
    if (while_waiting) std::exchange(while_waiting, nullptr)();
    if (deliver()) return 0;
    pollfd rings{bell, POLLIN, 0};
    if (poll(&rings, 1, waits_truly ? 1 : 0) == 0) pass(longest);
    return 0;
  }
  const char* error_name(int error) const noexcept override { return libusb_error_name(error); }

 private:
  void pass(Duration time) {
    for (constexpr Duration kStep = std::chrono::milliseconds(5); as_time_passes && time > kStep;
         time -= kStep) {
      clock_.advance(kStep);
      as_time_passes();
    }
    clock_.advance(time);
    if (as_time_passes) as_time_passes();
  }
  /// The interface for CAN and, as on candleLights, one for the firmware's update.
  struct Config : libusb_config_descriptor {
    explicit Config(const ScriptedAdapter& adapter) : libusb_config_descriptor{} {
      endpoints[0].bEndpointAddress = adapter.endpoint_in;
      endpoints[1].bEndpointAddress = adapter.endpoint_out;
      for (libusb_endpoint_descriptor& e : endpoints) {
        e.bmAttributes = adapter.has_bulk ? LIBUSB_TRANSFER_TYPE_BULK : LIBUSB_TRANSFER_TYPE_INTERRUPT;
      }
      settings[0].bInterfaceNumber = adapter.interface;
      settings[0].bNumEndpoints = 2;
      settings[0].endpoint = endpoints.data();
      settings[1].bInterfaceNumber = adapter.interface == 0 ? 1 : 0;
      for (std::size_t i = 0; i < 2; ++i) {
        interfaces[i].altsetting = &settings[adapter.interface == 0 ? i : 1 - i];
        interfaces[i].num_altsetting = 1;
      }
      interface = interfaces.data();
      bNumInterfaces = 2;
    }
    std::array<libusb_endpoint_descriptor, 2> endpoints{};
    std::array<libusb_interface_descriptor, 2> settings{};
    std::array<libusb_interface, 2> interfaces{};
  };

  void count() {
    if (calls_until_unplugged > 0 && --calls_until_unplugged == 0) plugged_.clear();
  }
  bool is_there(const libusb_device* device) const {
    return std::any_of(plugged_.begin(), plugged_.end(),
                       [&](const libusb_device& d) { return d.plugging == device->plugging; });
  }

  static int answer(ScriptedAdapter& adapter, std::uint8_t type, std::uint8_t request, std::uint16_t value,
                    std::span<std::uint8_t> data) {
    if (type == 0x41)
      return adapter.tell(request, value, data) ? static_cast<int>(data.size()) : LIBUSB_ERROR_PIPE;
    if (type != 0xC1) return LIBUSB_ERROR_PIPE;
    const auto bytes = adapter.ask(request, value);
    if (!bytes) return LIBUSB_ERROR_PIPE;
    const std::size_t n = std::min(bytes->size(), data.size());
    std::copy_n(bytes->begin(), n, data.begin());
    return static_cast<int>(n);
  }

  /// Calls back what is done, oldest first; true when there was something.
  bool deliver() {
    std::vector<libusb_transfer*> finished;
    std::erase_if(under_way_, [&](libusb_transfer* t) {
      const bool is_finished = finish(*t);
      if (is_finished) finished.push_back(t);
      return is_finished;
    });
    for (libusb_transfer* t : finished) {
      cancelled_.erase(t);
      clock_.advance(std::chrono::microseconds(10));
      t->callback(t);
    }
    return !finished.empty();
  }

  /// False while it stays under way.
  bool finish(libusb_transfer& t) {
    ScriptedAdapter& adapter = *t.dev_handle->device->adapter;
    const bool is_read = t.endpoint == adapter.endpoint_in;
    t.actual_length = 0;
    if (is_read ? adapter.keeps_reads : adapter.keeps_writes) return false;
    if (!is_there(t.dev_handle->device)) {
      t.status = LIBUSB_TRANSFER_NO_DEVICE;
    } else if (cancelled_.contains(&t)) {
      t.status = LIBUSB_TRANSFER_CANCELLED;
    } else if (int& stalls = is_read ? adapter.stalls_reads : adapter.stalls_writes; stalls > 0) {
      --stalls;
      t.status = LIBUSB_TRANSFER_STALL;
    } else if (is_read) {
      return finish_read(t, adapter);
    } else {
      adapter.take({t.buffer, static_cast<std::size_t>(t.length)});
      t.actual_length = t.length;
      t.status = LIBUSB_TRANSFER_COMPLETED;
    }
    return true;
  }
  static bool finish_read(libusb_transfer& t, ScriptedAdapter& adapter) {
    if (adapter.breaks_reads > 0) {
      --adapter.breaks_reads;
      t.status = LIBUSB_TRANSFER_ERROR;
      return true;
    }
    if (adapter.outbox.empty()) return false;
    const auto bytes = adapter.outbox.front();
    adapter.outbox.pop_front();
    const std::size_t n = std::min(bytes.size(), static_cast<std::size_t>(t.length));
    std::copy_n(bytes.begin(), n, t.buffer);
    t.actual_length = static_cast<int>(n);
    t.status = n < bytes.size() ? LIBUSB_TRANSFER_OVERFLOW : LIBUSB_TRANSFER_COMPLETED;
    return true;
  }

  hal::ManualClock& clock_;
  std::deque<libusb_device> plugged_;
  int pluggings_ = 0;
  bool detaches_ = false;
  Held held_;
  std::deque<libusb_transfer*> under_way_;
  std::set<libusb_transfer*> cancelled_;
};

}  // namespace headway::drivers::testing
