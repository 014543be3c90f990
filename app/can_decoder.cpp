#include "app/can_decoder.h"

#include <algorithm>
#include <array>
#include <initializer_list>

#include "hal/bus_codec.h"
#include "hal/emergency.h"

namespace headway::app {

namespace bus = hal::bus;

CanopenPlace canopen_place(std::uint32_t id) noexcept {
  // By the identifier's upper four bits; the lower seven are the node.
  constexpr std::array<std::string_view, 16> kOfNodes{
      "",      "EMCY",  "",      "TPDO1",      "RPDO1",       "TPDO2", "RPDO2",     "TPDO3",
      "RPDO3", "TPDO4", "RPDO4", "SDO answer", "SDO request", "",      "heartbeat", ""};
  const std::uint32_t code = id >> 7, node = id & 0x7F;
  if (id == 0x000) return {"NMT", 0};
  if (id == 0x080) return {"SYNC", 0};
  if (id == 0x100) return {"TIME", 0};
  if (code >= kOfNodes.size() || node == 0 || kOfNodes[code].empty()) return {};
  return {kOfNodes[code], static_cast<int>(node)};
}

DecodedCounts& DecodedCounts::operator+=(const DecodedCounts& other) noexcept {
  for (const auto count : {&DecodedCounts::frames, &DecodedCounts::unknown, &DecodedCounts::undeclared,
                           &DecodedCounts::wrong_crc, &DecodedCounts::repeated,
                           &DecodedCounts::wrong_sequence, &DecodedCounts::lost})
    this->*count += other.*count;
  return *this;
}

namespace {

/// Words of bits, and numbers of errors and objects.
int hex_digits(const CanopenPlace& place, std::string_view signal) {
  const auto is_one_of = [&](std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), signal) != names.end();
  };
  if (place.function.empty() || place.function == "NMT") return 0;
  if (is_one_of({"Code", "Index", "Controlword", "Statusword"})) return 4;
  return is_one_of({"ErrorRegister", "Vendor", "Command", "Subindex", "Data"}) ? 2 : 0;
}

std::string_view meaning_of(const CanopenPlace& place, const bus::SignalInfo& signal, double value) {
  if (place.function == "EMCY" && signal.name == "Code")
    return hal::name_of_emergency(static_cast<std::uint16_t>(value));
  for (const bus::NamedValue& named : signal.names)
    if (named.value == value) return named.name;
  return {};
}

}  // namespace

CanDecoder::CanDecoder() {
  for (const bus::MessageInfo& m : bus::messages())
    if (m.data_id != 0) checkers_.emplace(m.id, bus::ProtectionChecker(m.data_id));
}

DecodedFrame CanDecoder::decode(const hal::CanFrame& frame) {
  DecodedFrame decoded;
  decoded.canopen = canopen_place(frame.id);
  ++counts_.frames;
  const bus::MessageInfo* message = bus::find_message(frame.id);
  if (!message) {
    ++counts_.unknown;
    return decoded;
  }
  decoded.name = message->name;
  if (const auto checker = checkers_.find(frame.id); checker != checkers_.end())
    decoded.check = checker->second.check(frame);
  std::vector<double> values(message->signals.size());
  decoded.declared = bus::unpack_values(frame, values);
  if (!decoded.declared) {
    ++counts_.undeclared;
    return decoded;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bus::SignalInfo& signal = message->signals[i];
    decoded.signals.push_back({signal.name, values[i], signal.unit,
                               meaning_of(decoded.canopen, signal, values[i]),
                               hex_digits(decoded.canopen, signal.name)});
  }
  return decoded;
}

DecodedCounts CanDecoder::counts() const {
  DecodedCounts sum = counts_;
  for (const auto& [id, checker] : checkers_) {
    sum.wrong_crc += checker.counts().wrong_crc;
    sum.repeated += checker.counts().repeated;
    sum.wrong_sequence += checker.counts().wrong_sequence;
    sum.lost += checker.counts().lost;
  }
  return sum;
}

std::string_view name_of(bus::Check check) noexcept {
  switch (check) {
    case bus::Check::kOk:
      return "ok";
    case bus::Check::kOkSomeLost:
      return "ok, some lost";
    case bus::Check::kWrongCrc:
      return "wrong CRC";
    case bus::Check::kRepeated:
      return "repeated";
    case bus::Check::kWrongSequence:
      return "wrong sequence";
  }
  return "";
}

}  // namespace headway::app
