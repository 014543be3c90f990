// hil_usb_adapter: an emulated candleLight adapter, plugged into the kernel that it runs on.

#include <array>
#include <cstdio>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "hal/clock.h"
#include "tests/hil/emulated_gs_usb.h"
#include "tests/hil/usb_program.h"

namespace headway::hil {
namespace {

using Fault = EmulatedGsUsb::Fault;
using BusState = EmulatedGsUsb::BusState;

constexpr const char* kCommands = R"(Commands, one a line, into the pipe:
  plug | unplug
  stall 0x81 | stall 0x02 | stall 0   an endpoint until the host clears it, or the next control request
  state active | warning | passive | bus-off
  next echo | channel | dlc | half | long | overflow   what is wrong with the next packet to the host
  hold | release        the host's answers come late, all at once
  deaf | hearing        nobody acknowledges: echoes never come
  frame ID HEX          a frame of another node, as in: frame 123 11223344)";

template <typename Value, std::size_t kSize>
std::optional<Value> named(const std::array<std::pair<const char*, Value>, kSize>& table,
                           const std::string& name) {
  for (const auto& [key, value] : table) {
    if (name == key) return value;
  }
  return std::nullopt;
}

constexpr std::array<std::pair<const char*, BusState>, 4> kStates{{{"active", BusState::kActive},
                                                                   {"warning", BusState::kWarning},
                                                                   {"passive", BusState::kPassive},
                                                                   {"bus-off", BusState::kBusOff}}};
constexpr std::array<std::pair<const char*, Fault>, 6> kFaults{{{"echo", Fault::kUnknownEcho},
                                                                {"channel", Fault::kWrongChannel},
                                                                {"dlc", Fault::kWrongDlc},
                                                                {"half", Fault::kHalf},
                                                                {"long", Fault::kLong},
                                                                {"overflow", Fault::kOverflow}}};

Bytes bytes_of_hex(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::strtoul(hex.substr(i, 2).c_str(), nullptr, 16)));
  }
  return bytes;
}

bool obey_word(EmulatedGsUsb& adapter, const std::string& word) {
  if (word == "hold" || word == "release") {
    adapter.hold(word == "hold");
  } else if (word == "deaf" || word == "hearing") {
    adapter.set_deaf(word == "deaf");
  } else {
    return false;
  }
  return true;
}

bool obey(EmulatedGsUsb& adapter, const Command& command) {
  if (command.size() == 1) return obey_word(adapter, command[0]);
  if (command.size() == 2 && command[0] == "state") {
    const auto state = named(kStates, command[1]);
    if (state) adapter.set_bus_state(*state);
    return state.has_value();
  }
  if (command.size() == 2 && command[0] == "next") {
    const auto fault = named(kFaults, command[1]);
    if (fault) adapter.inject(*fault);
    return fault.has_value();
  }
  if (command.size() >= 2 && command[0] == "frame") {
    const auto id = static_cast<std::uint32_t>(std::strtoul(command[1].c_str(), nullptr, 16));
    adapter.bus_frame(id, bytes_of_hex(command.size() > 2 ? command[2] : ""));
    return true;
  }
  return false;
}

int run(int argc, char** argv) {
  std::string serial = "HEADWAY1", pipe;
  unsigned port_number = 0;
  CLI::App app("An emulated candleLight USB-CAN adapter, plugged into this kernel until it is ended.");
  app.footer(kCommands);
  app.add_option("--serial", serial, "Its serial number")->capture_default_str();
  app.add_option("--port", port_number, "Port of the virtual USB host, 0 to 7")->capture_default_str();
  app.add_option("--commands", pipe, "The named pipe that it makes and obeys")->required();
  CLI11_PARSE(app, argc, argv);

  const hal::MonotonicClock clock;
  EmulatedGsUsb adapter(serial, clock);
  UsbipPort port(adapter, attach_to_kernel(port_number));
  CommandPipe commands(pipe);
  run_usb_program(
      port, commands, [&](const Command& command) { return obey(adapter, command); }, [] { return -1; });
  fmt::print("sent {}, misused {}\n", adapter.counts().sent, adapter.counts().misused);
  return 0;
}

}  // namespace
}  // namespace headway::hil

int main(int argc, char** argv) {
  return headway::hil::run_reporting("hil_usb_adapter", headway::hil::run, argc, argv);
}
