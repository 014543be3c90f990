#include "sim_hal/object_dictionary.h"

#include <limits>

namespace headway::sim {
namespace {

using Limits32 = std::numeric_limits<std::int32_t>;
constexpr std::int64_t kU8 = 0xff, kU16 = 0xffff, kU32 = 0xffffffff;
constexpr std::int64_t kMilliDegree = 0xFD410000, kMilliDegreePerSecond = 0xFD410300;
constexpr std::int64_t kPdoInvalid = 0x80000000;

constexpr bool is_pdo_identifier(std::uint16_t index, std::uint8_t sub) {
  return sub == 1 && (index == 0x1400 || index == 0x1800 || index == 0x1801);
}
constexpr bool is_transmission_type(std::uint16_t index, std::uint8_t sub) {
  return sub == 2 && (index == 0x1400 || index == 0x1800 || index == 0x1801);
}
constexpr bool is_mapping(std::uint16_t index) {
  return index == 0x1600 || index == 0x1A00 || index == 0x1A01;
}

std::int64_t from_bytes(std::span<const std::uint8_t> bytes, bool is_signed) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) value |= std::uint64_t{bytes[i]} << (8 * i);
  const int unused = 64 - 8 * static_cast<int>(bytes.size());
  return is_signed ? static_cast<std::int64_t>(value << unused) >> unused : static_cast<std::int64_t>(value);
}

/// Values that this drive can do, where the standard lists more.
bool supported(std::uint16_t index, std::uint8_t sub, std::int64_t value) {
  switch (index) {
    case 0x605A:
      return value == 0 || value == 1 || value == 2 || value == 5 || value == 6;
    case 0x605E:
      return value >= 0 && value <= 2;
    case 0x6060:
      return value == 0 || value == 1 || value == 6 || value == 8;
    case 0x6098:
      return (value >= 1 && value <= 30) || value == 37;
    case 0x60C2:
      return sub != 2 || value == -3;
    case 0x60A8:
      return value == kMilliDegree;
    default:
      return !is_transmission_type(index, sub) || value <= 240 || value >= 254;
  }
}

}  // namespace

void ObjectDictionary::add(const Object& object) { objects_[size_++] = object; }

void ObjectDictionary::add_unsigned(std::uint16_t index, std::uint8_t sub, std::uint8_t bytes, Access access,
                                    std::int64_t value, std::int64_t lowest, std::int64_t highest) {
  add({.index = index,
       .sub = sub,
       .bytes = bytes,
       .access = access,
       .value = value,
       .lowest = lowest,
       .highest = highest});
}

void ObjectDictionary::add_pdo(std::uint16_t communication, std::uint16_t mapping, std::uint32_t id,
                               std::initializer_list<std::uint32_t> mapped) {
  add_unsigned(communication, 0, 1, Access::kReadOnly, 2, 0, kU8);
  add_unsigned(communication, 1, 4, Access::kReadWrite, id, 0, kU32);
  add_unsigned(communication, 2, 1, Access::kReadWrite, 255, 0, kU8);
  add_unsigned(mapping, 0, 1, Access::kReadWrite, static_cast<std::int64_t>(mapped.size()), 0, 8);
  for (std::uint8_t sub = 1; sub <= 8; ++sub) {
    add_unsigned(mapping, sub, 4, Access::kReadWrite, sub <= mapped.size() ? mapped.begin()[sub - 1] : 0, 0,
                 kU32);
  }
}

void ObjectDictionary::add_communication(std::uint8_t node) {
  using enum Access;
  add_unsigned(0x1000, 0, 4, kReadOnly, 0x00020192, 0, kU32);  // CiA 402, servo drive
  add_unsigned(0x1001, 0, 1, kReadOnly, 0, 0, kU8);
  add_unsigned(0x1005, 0, 4, kReadOnly, 0x80, 0, kU32);
  add_unsigned(0x1008, 0, 4, kReadOnly, 0x006D6953, 0, kU32);  // its name, a text of four bytes: "Sim"
  add_unsigned(0x1014, 0, 4, kReadOnly, 0x80 + node, 0, kU32);
  add_unsigned(0x1016, 0, 1, kReadOnly, 1, 0, kU8);
  add_unsigned(0x1016, 1, 4, kReadWrite, 0, 0, 0x007fffff);
  add_unsigned(0x1017, 0, 2, kReadWrite, 0, 0, kU16);
  add_unsigned(0x1018, 0, 1, kReadOnly, 4, 0, kU8);
  add_unsigned(0x1018, 1, 4, kReadOnly, 0, 0, kU32);
  add_unsigned(0x1018, 2, 4, kReadOnly, 0x4845, 0, kU32);
  add_unsigned(0x1018, 3, 4, kReadOnly, 1, 0, kU32);
  add_unsigned(0x1018, 4, 4, kReadOnly, node, 0, kU32);
  // What happens to the network state on a communication error. The standard's own default is 0
  // (pre-operational); this drive stays on the bus, so that its quick stop can be seen.
  add_unsigned(0x1029, 0, 1, kReadOnly, 1, 0, kU8);
  add_unsigned(0x1029, 1, 1, kReadWrite, 1, 0, 2);
  add_pdo(0x1400, 0x1600, 0x200U + node, {0x60400010});
  add_pdo(0x1800, 0x1A00, 0x180U + node, {0x60410010});
  add_pdo(0x1801, 0x1A01, 0x280U + node, {0x60410010, 0x60610008});
}

void ObjectDictionary::add_profile() {
  using enum Access;
  const auto word = [this](std::uint16_t index, std::int64_t value, std::int64_t lowest,
                           std::int64_t highest) {
    add({.index = index,
         .bytes = 2,
         .is_signed = true,
         .value = value,
         .lowest = lowest,
         .highest = highest});
  };
  const auto mapped = [this](std::uint16_t index, std::uint8_t bytes, Access access, bool is_signed,
                             std::int64_t value, std::int64_t lowest, std::int64_t highest) {
    add({.index = index,
         .bytes = bytes,
         .access = access,
         .is_signed = is_signed,
         .mappable = true,
         .value = value,
         .lowest = lowest,
         .highest = highest});
  };
  const auto position = [this](std::uint16_t index, std::uint8_t sub, std::int64_t value) {
    add({.index = index,
         .sub = sub,
         .is_signed = true,
         .value = value,
         .lowest = Limits32::min(),
         .highest = Limits32::max()});
  };
  word(0x6007, 1, 0, 3);
  word(0x605A, 2, -32768, 32767);
  word(0x605E, 2, -32768, 32767);
  add_unsigned(0x603F, 0, 2, kReadOnly, 0, 0, kU16);
  mapped(0x6040, 2, kReadWrite, false, 0, 0, kU16);
  mapped(0x6041, 2, kReadOnly, false, 0, 0, kU16);
  mapped(0x6060, 1, kReadWrite, true, 0, -128, 127);
  mapped(0x6061, 1, kReadOnly, true, 0, -128, 127);
  mapped(0x6064, 4, kReadOnly, true, 0, Limits32::min(), Limits32::max());
  mapped(0x606C, 4, kReadOnly, true, 0, Limits32::min(), Limits32::max());
  mapped(0x607A, 4, kReadWrite, true, 0, Limits32::min(), Limits32::max());
  add_unsigned(0x6065, 0, 4, kReadWrite, 2000, 0, kU32);
  add_unsigned(0x6066, 0, 2, kReadWrite, 100, 0, kU16);
  add_unsigned(0x6067, 0, 4, kReadWrite, 50, 0, kU32);
  add_unsigned(0x6068, 0, 2, kReadWrite, 10, 0, kU16);
  add_unsigned(0x607D, 0, 1, kReadOnly, 2, 0, kU8);
  position(0x607D, 1, -180000);
  position(0x607D, 2, 180000);
  add_unsigned(0x6081, 0, 4, kReadWrite, 10000, 1, kU32);
  add_unsigned(0x6083, 0, 4, kReadWrite, 50000, 1, kU32);
  add_unsigned(0x6084, 0, 4, kReadWrite, 50000, 1, kU32);
  add_unsigned(0x6085, 0, 4, kReadWrite, 200000, 1, kU32);
  add_unsigned(0x60A8, 0, 4, kReadWrite, kMilliDegree, 0, kU32);
  add_unsigned(0x60A9, 0, 4, kReadOnly, kMilliDegreePerSecond, 0, kU32);
  add_unsigned(0x60C2, 0, 1, kReadOnly, 2, 0, kU8);
  add_unsigned(0x60C2, 1, 1, kReadWrite, 1, 1, kU8);
  add({.index = 0x60C2,
       .sub = 2,
       .bytes = 1,
       .is_signed = true,
       .value = -3,
       .lowest = -128,
       .highest = 127});
  add({.index = 0x6098, .bytes = 1, .is_signed = true, .value = 37, .lowest = -128, .highest = 127});
  add_unsigned(0x6099, 0, 1, kReadOnly, 2, 0, kU8);
  add_unsigned(0x6099, 1, 4, kReadWrite, 5000, 1, kU32);
  add_unsigned(0x6099, 2, 4, kReadWrite, 1000, 1, kU32);
  add_unsigned(0x609A, 0, 4, kReadWrite, 20000, 1, kU32);
  add_unsigned(0x6502, 0, 4, kReadOnly, 0xA1, 0,
               kU32);  // profile position, homing, cyclic synchronous position
}

ObjectDictionary ObjectDictionary::head_drive(std::uint8_t node) {
  ObjectDictionary d;
  d.add_communication(node);
  d.add_profile();
  return d;
}

const Object* ObjectDictionary::find(std::uint16_t index, std::uint8_t sub) const noexcept {
  for (std::size_t i = 0; i < size_; ++i)
    if (objects_[i].index == index && objects_[i].sub == sub) return &objects_[i];
  return nullptr;
}

Object* ObjectDictionary::find(std::uint16_t index, std::uint8_t sub) noexcept {
  return const_cast<Object*>(static_cast<const ObjectDictionary*>(this)->find(index, sub));
}

bool ObjectDictionary::has_index(std::uint16_t index) const noexcept { return find(index, 0) != nullptr; }

std::int64_t ObjectDictionary::get(std::uint16_t index, std::uint8_t sub) const noexcept {
  const Object* object = find(index, sub);
  return object == nullptr ? 0 : object->value;
}

void ObjectDictionary::set(std::uint16_t index, std::uint8_t sub, std::int64_t value) noexcept {
  if (Object* object = find(index, sub)) object->value = value;
}

SdoAbort ObjectDictionary::readable(std::uint16_t index, std::uint8_t sub) const noexcept {
  const Object* object = find(index, sub);
  if (object == nullptr) return has_index(index) ? SdoAbort::kNoSubIndex : SdoAbort::kNoObject;
  return object->access == Access::kWriteOnly ? SdoAbort::kWriteOnly : SdoAbort::kNone;
}

SdoAbort ObjectDictionary::write(std::uint16_t index, std::uint8_t sub,
                                 std::span<const std::uint8_t> bytes) noexcept {
  Object* object = find(index, sub);
  if (object == nullptr) return has_index(index) ? SdoAbort::kNoSubIndex : SdoAbort::kNoObject;
  if (object->access == Access::kReadOnly) return SdoAbort::kReadOnly;
  if (bytes.size() != object->bytes) return SdoAbort::kWrongLength;
  const std::int64_t value = from_bytes(bytes, object->is_signed);
  if (value > object->highest) return SdoAbort::kTooHigh;
  if (value < object->lowest) return SdoAbort::kTooLow;
  if (!supported(index, sub, value)) return SdoAbort::kBadValue;
  if (const SdoAbort refused = check_pdo(index, sub, value); refused != SdoAbort::kNone) return refused;
  object->value = value;
  return SdoAbort::kNone;
}

/// CiA 301: a PDO is switched off before its identifier or mapping changes, the mapping emptied before its
/// entries.
SdoAbort ObjectDictionary::check_pdo(std::uint16_t index, std::uint8_t sub,
                                     std::int64_t value) const noexcept {
  if (is_pdo_identifier(index, sub)) {
    const std::int64_t now = get(index, sub);
    const bool stays_on = (now & kPdoInvalid) == 0 && (value & kPdoInvalid) == 0;
    return stays_on && ((now ^ value) & 0x7ff) != 0 ? SdoAbort::kBadValue : SdoAbort::kNone;
  }
  if (!is_mapping(index)) return SdoAbort::kNone;
  const auto communication = static_cast<std::uint16_t>(index - 0x200);
  if ((get(communication, 1) & kPdoInvalid) == 0) return SdoAbort::kUnsupportedAccess;
  if (sub > 0) {
    if (get(index, 0) != 0) return SdoAbort::kUnsupportedAccess;
    return can_map(index, value) ? SdoAbort::kNone : SdoAbort::kNotMappable;
  }
  std::int64_t bits = 0;
  for (std::uint8_t entry = 1; entry <= value; ++entry) {
    const std::int64_t mapped = get(index, entry);
    if (!can_map(index, mapped)) return SdoAbort::kNotMappable;
    bits += mapped & 0xff;
  }
  return bits > 64 ? SdoAbort::kMappingTooLong : SdoAbort::kNone;
}

bool ObjectDictionary::can_map(std::uint16_t mapping, std::int64_t entry) const noexcept {
  const Object* object = find(static_cast<std::uint16_t>(entry >> 16), static_cast<std::uint8_t>(entry >> 8));
  if (object == nullptr || !object->mappable || 8 * object->bytes != (entry & 0xff)) return false;
  return mapping != 0x1600 || object->access != Access::kReadOnly;
}

void ObjectDictionary::restore_communication(const ObjectDictionary& from) noexcept {
  for (std::size_t i = 0; i < size_; ++i)
    if (objects_[i].index < 0x2000) objects_[i].value = from.objects_[i].value;
}

}  // namespace headway::sim
