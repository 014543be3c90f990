#include "app/can_transport.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "config/yaml_limits.h"
#include "drivers/gs_usb_bus.h"
#include "drivers/slcan_bus.h"
#include "drivers/socketcan_bus.h"
#include "hal/bus_codec.h"
#include "hal/error.h"

namespace headway::app {

namespace {

using Identifiers = std::vector<std::uint32_t>;

CanTransport open_socketcan(const std::string& interface, hal::Clock& clock, const Identifiers& listens_to) {
  return {std::make_unique<drivers::SocketCanBus>(
              drivers::SocketCanConfig{.interface = interface, .identifiers = listens_to}, clock),
          {},
          {}};
}

CanTransport open_slcan(const std::string& tty, hal::Clock& clock, const Identifiers&) {
  auto bus = std::make_unique<drivers::SlcanBus>(drivers::SlcanConfig{.path = tty}, clock);
  drivers::SlcanBus& serving = *bus;
  return {std::move(bus), [&serving](Duration at_most) { serving.serve(at_most); }, {}, false};
}

CanTransport open_gs_usb(const std::string& serial, hal::Clock& clock, const Identifiers&) {
  auto bus = std::make_unique<drivers::GsUsbBus>(drivers::GsUsbConfig{.serial = serial}, clock);
  drivers::GsUsbBus& serving = *bus;
  return {std::move(bus), [&serving](Duration at_most) { serving.serve(at_most); },
          fmt::format("firmware {}, hardware {}, {} channel(s)", serving.device().firmware,
                      serving.device().hardware, serving.device().channels)};
}

struct Kind {
  std::string_view prefix, example;
  CanTransport (*open)(const std::string&, hal::Clock&, const Identifiers&);
};
constexpr std::array kKinds{Kind{"socketcan:", "socketcan:can0", open_socketcan},
                            Kind{"gs_usb:", "gs_usb:SERIAL", open_gs_usb},
                            Kind{"slcan:", "slcan:/dev/ttyACM0", open_slcan}};

}  // namespace

std::string can_transports() {
  std::string all;
  for (const Kind& kind : kKinds) all += fmt::format("{}{}", all.empty() ? "" : " or ", kind.example);
  return all;
}

bool is_can_transport(std::string_view name) {
  return std::any_of(kKinds.begin(), kKinds.end(), [&](const Kind& kind) {
    return name.starts_with(kind.prefix) && name.size() > kind.prefix.size();
  });
}

std::vector<std::uint32_t> identifiers_of_the_loops() {
  Identifiers all;
  for (const hal::bus::MessageInfo& message : hal::bus::messages())
    if (message.sender != "VIS") all.push_back(message.id);
  return all;
}

CanTransport open_can_transport(const std::string& name, hal::Clock& clock, const Identifiers& listens_to) {
  for (const Kind& kind : kKinds)
    if (name.starts_with(kind.prefix)) return kind.open(name.substr(kind.prefix.size()), clock, listens_to);
  throw InputError(fmt::format("'{}' is no CAN transport, expected one like {}", config::one_line(name),
                               can_transports()));
}

std::unique_ptr<runtime::Thread> serve(const CanTransport& transport, const runtime::RealTime& real_time) {
  if (!transport.serve) return nullptr;
  const auto serve_it = [&](const std::atomic<bool>& stop) {
    while (!stop) transport.serve(seconds(0.1));
  };
  return std::make_unique<runtime::Thread>(runtime::ThreadId::kAdapter, serve_it, real_time);
}

}  // namespace headway::app
