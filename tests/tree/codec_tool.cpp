// Lets another program drive the bus codec, line by line, so that an independent reader of the DBC can be
// compared with it (tests/tree/bus_codec_test.py).
//   list                  -> "ID NAME BYTES SIGNAL ..." for each message, then "end"
//   pack ID VALUE...      -> the frame's bytes in hexadecimal ("-" for none), or "refused"
//   unpack ID HEX         -> one value per signal in physical units, or "refused"
//   crc ID HEX            -> the CRC that protects the frame, as a number
#include <array>
#include <cstdint>
#include <cstdio>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "hal/bus_codec.h"
#include "hal/bus_protection.h"

namespace {

using headway::hal::CanFrame;
namespace bus = headway::hal::bus;

void list() {
  for (const bus::MessageInfo& m : bus::messages()) {
    std::cout << m.id << ' ' << m.name << ' ' << int{m.dlc};
    for (const bus::SignalInfo& s : m.signals) std::cout << ' ' << s.name;
    std::cout << '\n';
  }
  std::cout << "end\n";
}

std::string hex_of(const CanFrame& frame) {
  std::ostringstream out;
  for (std::size_t i = 0; i < frame.dlc; ++i)
    out << std::hex << std::setw(2) << std::setfill('0') << int{frame.data[i]};
  return frame.dlc == 0 ? "-" : out.str();
}

CanFrame frame_of_hex(std::uint32_t id, const std::string& hex) {
  CanFrame frame{.id = id};
  for (std::size_t i = 0; hex != "-" && i + 1 < hex.size() && frame.dlc < 8; i += 2) {
    frame.data[frame.dlc++] = static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return frame;
}

void pack(std::istream& line, std::uint32_t id) {
  std::vector<double> values;
  for (double v = 0; line >> v;) values.push_back(v);
  const auto frame = bus::pack_values(id, values);
  std::cout << (frame ? hex_of(*frame) : "refused") << '\n';
}

void unpack(std::istream& line, std::uint32_t id) {
  std::string hex;
  line >> hex;
  std::array<double, 16> values{};
  if (!bus::unpack_values(frame_of_hex(id, hex), values)) {
    std::cout << "refused\n";
    return;
  }
  const std::size_t count = bus::find_message(id)->signals.size();
  for (std::size_t i = 0; i < count; ++i) std::cout << std::setprecision(17) << values[i] << ' ';
  std::cout << '\n';
}

void crc(std::istream& line, std::uint32_t id) {
  std::string hex;
  line >> hex;
  std::cout << int{bus::frame_crc(frame_of_hex(id, hex), bus::find_message(id)->data_id)} << '\n';
}

}  // namespace

int main() {
  for (std::string text; std::getline(std::cin, text);) {
    std::istringstream line(text);
    std::string word;
    std::uint32_t id = 0;
    line >> word >> id;
    if (word == "list") {
      list();
    } else if (word == "pack") {
      pack(line, id);
    } else if (word == "unpack") {
      unpack(line, id);
    } else if (word == "crc" && bus::find_message(id) != nullptr) {
      crc(line, id);
    } else {
      std::cerr << "codec_tool: cannot read: " << text << '\n';
      return 2;
    }
  }
  return 0;
}
