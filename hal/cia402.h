// CANopen (CiA 301) and drive profile (CiA 402) as tables with the standards' numbers: what the head master
// and a drive on the other side of the bus agree on.
#pragma once

#include <array>
#include <cstdint>

namespace headway::hal::cia402 {

// --- states of a drive (CiA 402, power drive system state machine) ---

enum class State : std::uint8_t {
  kNotReadyToSwitchOn,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReactionActive,
  kFault,
};

/// How a state shows in the statusword (object 0x6041): (word & mask) == value. The quick-stop bit (5) says
/// nothing where the mask is 0x4F.
struct StateCode {
  State state;
  std::uint16_t mask, value;
};
inline constexpr std::array<StateCode, 8> kStateCodes{{
    {State::kNotReadyToSwitchOn, 0x4F, 0x00},
    {State::kSwitchOnDisabled, 0x4F, 0x40},
    {State::kReadyToSwitchOn, 0x6F, 0x21},
    {State::kSwitchedOn, 0x6F, 0x23},
    {State::kOperationEnabled, 0x6F, 0x27},
    {State::kQuickStopActive, 0x6F, 0x07},
    {State::kFaultReactionActive, 0x4F, 0x0F},
    {State::kFault, 0x4F, 0x08},
}};

/// A word that fits no state is read as not ready: nothing is asked of such a drive.
constexpr State state_of(std::uint16_t statusword) noexcept {
  for (const StateCode& code : kStateCodes) {
    if ((statusword & code.mask) == code.value) return code.state;
  }
  return State::kNotReadyToSwitchOn;
}
/// The bits of a statusword that show a state.
constexpr std::uint16_t code_of(State state) noexcept {
  for (const StateCode& code : kStateCodes) {
    if (code.state == state) return code.value;
  }
  return 0;
}

// --- commands (bits 0..3 and 7 of the controlword, object 0x6040) ---

enum class Command : std::uint8_t {
  kNone,
  kShutdown,
  kSwitchOn,
  kDisableVoltage,
  kQuickStop,
  kDisableOperation,
  kEnableOperation,
  kFaultReset,  ///< acts on the rising edge of bit 7
};

/// A controlword gives the command when (word & mask) == value. The first that fits counts.
struct CommandCode {
  Command command;
  std::uint16_t mask, value;
};
inline constexpr std::array<CommandCode, 7> kCommandCodes{{
    {Command::kFaultReset, 0x80, 0x80},
    {Command::kDisableVoltage, 0x82, 0x00},
    {Command::kQuickStop, 0x86, 0x02},
    {Command::kShutdown, 0x87, 0x06},
    {Command::kSwitchOn, 0x8F, 0x07},
    {Command::kEnableOperation, 0x8F, 0x0F},
    // "Disable operation" has the bits of "switch on"; from Operation enabled it is read as this one.
    {Command::kDisableOperation, 0x8F, 0x07},
}};

constexpr Command command_of(std::uint16_t controlword) noexcept {
  for (const CommandCode& code : kCommandCodes) {
    if ((controlword & code.mask) == code.value) return code.command;
  }
  return Command::kNone;
}
constexpr std::uint16_t code_of(Command command) noexcept {
  for (const CommandCode& code : kCommandCodes) {
    if (code.command == command) return code.value;
  }
  return 0;
}

// --- transitions, by the standard's numbers ---

struct Transition {
  int number;
  State from, to;
  Command command;  ///< kNone: the drive does it by itself
};
inline constexpr std::array<Transition, 16> kTransitions{{
    {1, State::kNotReadyToSwitchOn, State::kSwitchOnDisabled, Command::kNone},
    {2, State::kSwitchOnDisabled, State::kReadyToSwitchOn, Command::kShutdown},
    {3, State::kReadyToSwitchOn, State::kSwitchedOn, Command::kSwitchOn},
    {4, State::kSwitchedOn, State::kOperationEnabled, Command::kEnableOperation},
    {5, State::kOperationEnabled, State::kSwitchedOn, Command::kDisableOperation},
    {6, State::kSwitchedOn, State::kReadyToSwitchOn, Command::kShutdown},
    {7, State::kReadyToSwitchOn, State::kSwitchOnDisabled, Command::kDisableVoltage},
    {8, State::kOperationEnabled, State::kReadyToSwitchOn, Command::kShutdown},
    {9, State::kOperationEnabled, State::kSwitchOnDisabled, Command::kDisableVoltage},
    {10, State::kSwitchedOn, State::kSwitchOnDisabled, Command::kDisableVoltage},
    {11, State::kOperationEnabled, State::kQuickStopActive, Command::kQuickStop},
    {12, State::kQuickStopActive, State::kSwitchOnDisabled, Command::kDisableVoltage},
    // 13 leads from every state to kFaultReactionActive; Operation enabled stands for all of them.
    {13, State::kOperationEnabled, State::kFaultReactionActive, Command::kNone},
    {14, State::kFaultReactionActive, State::kFault, Command::kNone},
    {15, State::kFault, State::kSwitchOnDisabled, Command::kFaultReset},
    {16, State::kQuickStopActive, State::kOperationEnabled, Command::kEnableOperation},
}};

/// Where a command leads; the same state when the standard knows no such transition.
constexpr State after(State from, Command command) noexcept {
  if (from == State::kOperationEnabled && command == Command::kSwitchOn) command = Command::kDisableOperation;
  // A quick stop asked of a drive without torque just disables it (also transitions 7 and 10).
  if (command == Command::kQuickStop && (from == State::kReadyToSwitchOn || from == State::kSwitchedOn)) {
    command = Command::kDisableVoltage;
  }
  for (const Transition& t : kTransitions) {
    if (t.from == from && t.command == command && command != Command::kNone) return t.to;
  }
  return from;
}

/// The transition that leads a drive one state nearer to Operation enabled; kNone where only the drive can
/// act.
constexpr Command towards_operation(State state) noexcept {
  constexpr std::array<int, 5> kWayUp{2, 3, 4, 15, 16};
  for (const Transition& t : kTransitions) {
    for (const int number : kWayUp) {
      if (t.number == number && t.from == state) return t.command;
    }
  }
  return Command::kNone;
}

// --- single bits ---

namespace status_bit {
inline constexpr std::uint16_t kWarning = 1 << 7;
inline constexpr std::uint16_t kRemote = 1 << 9;
inline constexpr std::uint16_t kTargetReached = 1 << 10;
inline constexpr std::uint16_t kSetPointAcknowledged = 1 << 12;  ///< profile position mode
inline constexpr std::uint16_t kFollows = 1 << 12;               ///< cyclic synchronous position mode
inline constexpr std::uint16_t kHomingAttained = 1 << 12;        ///< homing mode
inline constexpr std::uint16_t kHomingError = 1 << 13;           ///< homing mode
}  // namespace status_bit

namespace control_bit {
inline constexpr std::uint16_t kNewSetPoint = 1 << 4;   ///< profile position mode
inline constexpr std::uint16_t kChangeAtOnce = 1 << 5;  ///< profile position mode
inline constexpr std::uint16_t kRelative = 1 << 6;      ///< profile position mode
inline constexpr std::uint16_t kStartHoming = 1 << 4;   ///< homing mode
inline constexpr std::uint16_t kFaultReset = 1 << 7;
inline constexpr std::uint16_t kHalt = 1 << 8;
}  // namespace control_bit

// --- object dictionary ---

/// An object by index and sub-index, and its size on the wire.
struct Object {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::uint8_t bytes = 4;
  constexpr bool operator==(const Object&) const = default;
};

/// The entry of a PDO mapping that names an object: index, sub-index, length in bits.
constexpr std::uint32_t mapping_of(const Object& o) noexcept {
  return (std::uint32_t{o.index} << 16) | (std::uint32_t{o.subindex} << 8) | (8u * o.bytes);
}

namespace object {
// CiA 301
inline constexpr Object kConsumerHeartbeat{0x1016, 1, 4};  ///< node << 16 | milliseconds
inline constexpr Object kProducerHeartbeat{0x1017, 0, 2};  ///< [ms]
inline constexpr Object kRpdo1Id{0x1400, 1, 4};
inline constexpr Object kRpdo1Type{0x1400, 2, 1};
inline constexpr Object kRpdo1Count{0x1600, 0, 1};
inline constexpr Object kTpdo1Id{0x1800, 1, 4};
inline constexpr Object kTpdo1Type{0x1800, 2, 1};
inline constexpr Object kTpdo1Count{0x1A00, 0, 1};
inline constexpr Object kTpdo2Id{0x1801, 1, 4};
inline constexpr Object kTpdo2Type{0x1801, 2, 1};
inline constexpr Object kTpdo2Count{0x1A01, 0, 1};
// CiA 402
inline constexpr Object kAbortConnectionOption{0x6007, 0, 2};
inline constexpr Object kControlword{0x6040, 0, 2};
inline constexpr Object kStatusword{0x6041, 0, 2};
inline constexpr Object kQuickStopOption{0x605A, 0, 2};
inline constexpr Object kFaultReactionOption{0x605E, 0, 2};
inline constexpr Object kMode{0x6060, 0, 1};
inline constexpr Object kModeDisplay{0x6061, 0, 1};
inline constexpr Object kPosition{0x6064, 0, 4};
inline constexpr Object kFollowingErrorWindow{0x6065, 0, 4};
inline constexpr Object kFollowingErrorTimeout{0x6066, 0, 2};  ///< [ms]
inline constexpr Object kVelocity{0x606C, 0, 4};
inline constexpr Object kTarget{0x607A, 0, 4};
inline constexpr Object kPositionLimitLow{0x607D, 1, 4};
inline constexpr Object kPositionLimitHigh{0x607D, 2, 4};
inline constexpr Object kProfileVelocity{0x6081, 0, 4};
inline constexpr Object kProfileAcceleration{0x6083, 0, 4};
inline constexpr Object kProfileDeceleration{0x6084, 0, 4};
inline constexpr Object kQuickStopDeceleration{0x6085, 0, 4};
inline constexpr Object kHomingMethod{0x6098, 0, 1};
inline constexpr Object kHomingSearchSpeed{0x6099, 1, 4};
inline constexpr Object kHomingZeroSpeed{0x6099, 2, 4};
inline constexpr Object kHomingAcceleration{0x609A, 0, 4};
inline constexpr Object kSiUnitPosition{0x60A8, 0, 4};
inline constexpr Object kInterpolationPeriod{0x60C2, 1, 1};  ///< in units of 10^exponent s
inline constexpr Object kInterpolationExponent{0x60C2, 2, 1};
}  // namespace object

inline constexpr std::uint32_t kMilliDegree = 0xFD410000;  ///< CiA 303-2: prefix 10^-3, unit degree
inline constexpr std::int8_t kProfilePosition = 1;         ///< mode of operation
inline constexpr std::int8_t kHoming = 6;                  ///< mode of operation
inline constexpr std::int8_t kCyclicPosition = 8;          ///< mode of operation
inline constexpr std::uint32_t kPdoOff = 0x80000000;       ///< in a PDO's COB-id
inline constexpr std::uint32_t kPdoNoRemote = 0x40000000;  ///< in a TPDO's COB-id
inline constexpr std::uint8_t kOnEverySync = 1;            ///< PDO transmission type
inline constexpr std::uint8_t kAtOnce = 255;               ///< PDO transmission type

// --- communication (CiA 301): COB-id bases of the predefined connection set, SDO command bytes ---

inline constexpr std::uint32_t kEmcyBase = 0x080, kTpdo1Base = 0x180, kRpdo1Base = 0x200, kTpdo2Base = 0x280,
                               kSdoAnswerBase = 0x580, kSdoRequestBase = 0x600, kHeartbeatBase = 0x700;

namespace sdo {
/// Expedited download of 1, 2, 3, 4 bytes (0x2F, 0x2B, 0x27, 0x23).
constexpr std::uint8_t download(int bytes) noexcept {
  return static_cast<std::uint8_t>(0x23 | ((4 - bytes) << 2));
}
/// Expedited answer to an upload with 1, 2, 3, 4 bytes (0x4F, 0x4B, 0x47, 0x43).
constexpr std::uint8_t uploaded(int bytes) noexcept {
  return static_cast<std::uint8_t>(0x43 | ((4 - bytes) << 2));
}
inline constexpr std::uint8_t kDownloaded = 0x60, kUpload = 0x40, kAbort = 0x80;
// Abort codes
inline constexpr std::uint32_t kNoSuchObject = 0x06020000, kNoSuchSubindex = 0x06090011,
                               kReadOnly = 0x06010002, kWrongLength = 0x06070010, kValueRange = 0x06090030,
                               kUnknownCommand = 0x05040001;
}  // namespace sdo

}  // namespace headway::hal::cia402
