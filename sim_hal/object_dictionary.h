// The objects of a drive that can be read and written over the bus, with types, access and ranges (CiA 301
// abort codes).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>

namespace headway::sim {

/// CiA 301 SDO abort codes.
enum class SdoAbort : std::uint32_t {
  kNone = 0,
  kUnknownCommand = 0x05040001,
  kUnsupportedAccess = 0x06010000,
  kWriteOnly = 0x06010001,
  kReadOnly = 0x06010002,
  kNoObject = 0x06020000,
  kNotMappable = 0x06040041,
  kMappingTooLong = 0x06040042,
  kWrongLength = 0x06070010,
  kNoSubIndex = 0x06090011,
  kBadValue = 0x06090030,
  kTooHigh = 0x06090031,
  kTooLow = 0x06090032,
  kDeviceState = 0x08000022,
};

enum class Access : std::uint8_t { kReadOnly, kReadWrite, kWriteOnly };

/// One sub-index. Values are kept as the 32 bits that travel, sign-extended.
struct Object {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t bytes = 4;
  Access access = Access::kReadWrite;
  bool is_signed = false;
  bool mappable = false;
  std::int64_t value = 0, lowest = 0, highest = 0;  ///< the range allowed to writers
};

/// Fixed set of objects; no heap after construction.
class ObjectDictionary {
 public:
  static constexpr std::size_t kCapacity = 112;

  /// The objects of a head drive with the values after a reset. Position unit 0.001 deg.
  static ObjectDictionary head_drive(std::uint8_t node);

  const Object* find(std::uint16_t index, std::uint8_t sub) const noexcept;
  bool has_index(std::uint16_t index) const noexcept;
  /// Value of an object that is known to exist.
  std::int64_t get(std::uint16_t index, std::uint8_t sub = 0) const noexcept;
  /// Sets from within the drive, without checks.
  void set(std::uint16_t index, std::uint8_t sub, std::int64_t value) noexcept;
  /// As the SDO server writes: little-endian bytes; checks existence, access, length and range.
  SdoAbort write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes) noexcept;
  /// As the SDO server reads.
  SdoAbort readable(std::uint16_t index, std::uint8_t sub) const noexcept;
  /// Copies the communication objects (0x1000 to 0x1FFF) of another dictionary of the same shape.
  void restore_communication(const ObjectDictionary& from) noexcept;

 private:
  void add(const Object& object);
  void add_unsigned(std::uint16_t index, std::uint8_t sub, std::uint8_t bytes, Access access,
                    std::int64_t value, std::int64_t lowest, std::int64_t highest);
  void add_pdo(std::uint16_t communication, std::uint16_t mapping, std::uint32_t id,
               std::initializer_list<std::uint32_t> mapped);
  void add_communication(std::uint8_t node);
  void add_profile();
  Object* find(std::uint16_t index, std::uint8_t sub) noexcept;
  SdoAbort check_pdo(std::uint16_t index, std::uint8_t sub, std::int64_t value) const noexcept;
  bool can_map(std::uint16_t mapping, std::int64_t entry) const noexcept;

  std::array<Object, kCapacity> objects_{};
  std::size_t size_ = 0;
};

}  // namespace headway::sim
