// What a frame on the robot's bus says: its name and values by the contract (docs/bus.md), its function and
// node by CANopen, and whether counter and CRC let it be used.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/bus_protection.h"
#include "hal/can_bus.h"

namespace headway::app {

/// The place of an identifier in CANopen's predefined connection set (CiA 301, 7.3.5).
struct CanopenPlace {
  std::string_view function;  ///< "TPDO1", "SDO answer", ...; empty: none
  int node = 0;               ///< 1..127; 0: of all nodes
};
CanopenPlace canopen_place(std::uint32_t id) noexcept;

struct SignalValue {
  std::string_view name;
  double value = 0;
  std::string_view unit;     ///< of the value; may be empty
  std::string_view meaning;  ///< as the contract or the standard calls this value; empty: it has no name
  int hex_digits = 0;        ///< as which CANopen writes it, at least so many; 0: it is an ordinary number
};

struct DecodedFrame {
  std::string_view name;  ///< of the message; empty: the contract knows no such identifier
  CanopenPlace canopen{};
  std::optional<hal::bus::Check> check;  ///< of those with counter and CRC
  bool declared = false;                 ///< length and values are such as the contract allows
  std::vector<SignalValue> signals;      ///< none where it is not declared
};

/// How many frames there were.
struct DecodedCounts {
  std::uint64_t frames = 0, unknown = 0;  ///< all; those that the contract does not know
  std::uint64_t undeclared = 0;           ///< known, but of another length or with other values
  std::uint64_t wrong_crc = 0, repeated = 0, wrong_sequence = 0;
  std::uint64_t lost = 0;  ///< that never came, told by the counter

  DecodedCounts& operator+=(const DecodedCounts& other) noexcept;
};

/// Frames of one bus, in order: the counters are followed.
class CanDecoder {
 public:
  CanDecoder();
  DecodedFrame decode(const hal::CanFrame& frame);
  DecodedCounts counts() const;

 private:
  std::map<std::uint32_t, hal::bus::ProtectionChecker> checkers_;
  DecodedCounts counts_;
};

/// "ok", "ok, some lost", "wrong CRC", "repeated" or "wrong sequence".
std::string_view name_of(hal::bus::Check check) noexcept;

}  // namespace headway::app
