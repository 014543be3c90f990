#include "tests/hil/emulated_gs_usb.h"

#include <algorithm>
#include <utility>

#include <linux/can.h>
#include <linux/can/error.h>

namespace headway::hil {
namespace {

// Control requests, and which of them carry data to the adapter.
constexpr std::uint8_t kHostFormat = 0, kBitTiming = 1, kMode = 2, kBusErrors = 3, kBitTimingLimits = 4,
                       kDeviceConfig = 5, kTimestamp = 6, kIdentify = 7, kGetState = 14;
constexpr std::size_t kBitTimingSize = 20, kModeSize = 8, kWordSize = 4;
constexpr std::uint32_t kLittleEndian = 0x0000beef;
constexpr std::uint32_t kModeReset = 0, kModeStart = 1;

// Features, and flags of MODE.
constexpr std::uint32_t kListenOnly = 1U << 0, kLoopBack = 1U << 1, kStamps = 1U << 4, kIdentifies = 1U << 5,
                        kTellsState = 1U << 13;

constexpr std::uint32_t kNoEcho = 0xffffffff, kUnknownEcho = 0x00decade;
constexpr std::size_t kFrameSize = 20, kStampSize = 4, kDlcAt = 8, kChannelAt = 9, kFlagsAt = 10,
                      kDataAt = 12;
constexpr std::uint8_t kOverflowFlag = 1;
constexpr std::size_t kSlots = 10;

// Full speed, as the real one has: its bulk endpoints take 64 bytes.
const Bytes kDeviceDescriptor{18, 1, 0x00, 0x02, 0, 0, 0, 64, 0x50, 0x1d, 0x6f, 0x60, 0, 0, 1, 2, 3, 1};
const Bytes kConfiguration{9,   2,    32,
                           0,   1,    1,
                           0,   0x80, 75,  // one interface, from the bus 150 mA
                           9,   4,    0,
                           0,   2,    255,
                           255, 255,  0,  // vendor's class, two endpoints
                           7,   5,    EmulatedGsUsb::kIn,
                           2,   64,   0,
                           0,  // bulk
                           7,   5,    EmulatedGsUsb::kOut,
                           2,   64,   0,
                           0};

Bytes words(std::initializer_list<std::uint32_t> values) {
  Bytes bytes;
  for (std::uint32_t value : values) append_le(bytes, value, 4);
  return bytes;
}

}  // namespace

EmulatedGsUsb::EmulatedGsUsb(std::string serial, const hal::Clock& clock)
    : description_{.speed = UsbSpeed::kFull,
                   .device = kDeviceDescriptor,
                   .configuration = kConfiguration,
                   .strings = {"Headway", "emulated candleLight", std::move(serial)}},
      clock_(clock) {}

void EmulatedGsUsb::power_on() {
  started_ = stamped_ = false;
  state_ = BusState::kActive;
  fault_ = Fault::kNone;
  to_host_.clear();
  in_flight_ = 0;
}

std::optional<Bytes> EmulatedGsUsb::request(const SetupPacket& setup, ByteSpan sent) {
  if (setup.to_host()) return tell(setup);
  if (!apply(setup, sent)) {
    ++counts_.misused;
    return std::nullopt;
  }
  return Bytes{};
}

bool EmulatedGsUsb::apply(const SetupPacket& setup, ByteSpan sent) {
  switch (setup.request) {
    case kHostFormat:
      return read_le(sent, 0, 4) == kLittleEndian;
    case kBitTiming:
      return setup.value == 0 && sent.size() == kBitTimingSize;
    case kBusErrors:
    case kIdentify:
      return sent.size() == kWordSize;
    case kMode: {
      const std::uint32_t mode = read_le(sent, 0, 4);
      if (setup.value != 0 || sent.size() != kModeSize || mode > kModeStart) return false;
      power_on();
      started_ = mode != kModeReset;
      stamped_ = started_ && (read_le(sent, 4, 4) & kStamps) != 0;
      return true;
    }
    default:
      return false;
  }
}

std::optional<Bytes> EmulatedGsUsb::tell(const SetupPacket& setup) const {
  switch (setup.request) {
    case kBitTimingLimits:  // features, clock in Hz, tseg1, tseg2, sjw, brp with its increment
      return words({kListenOnly | kLoopBack | kStamps | kIdentifies | kTellsState, 48'000'000, 1, 16, 1, 8, 4,
                    1, 1024, 1});
    case kDeviceConfig:  // the last channel's number in the first word's top byte; versions of software and
                         // hardware
      return words({0, 2, 1});
    case kTimestamp:
      return words({microseconds()});
    case kGetState:
      return words({static_cast<std::uint32_t>(state_), 0, 0});
    default:
      return std::nullopt;
  }
}

void EmulatedGsUsb::receive(std::uint8_t, ByteSpan bytes) {
  const bool fits = bytes.size() >= kFrameSize && bytes[kDlcAt] <= 8 && bytes[kChannelAt] == 0;
  if (!fits || !started_ || in_flight_ >= kSlots) {
    ++counts_.misused;
    return;
  }
  ++in_flight_;
  if (deaf_ || state_ == BusState::kBusOff) return;
  ++counts_.sent;
  Packet echo{.echo = read_le(bytes, 0, 4), .id = read_le(bytes, 4, 4), .dlc = bytes[kDlcAt], .data = {}};
  std::copy_n(bytes.begin() + kDataAt, echo.data.size(), echo.data.begin());
  Packet answer = echo;
  answer.echo = kNoEcho;
  answer.id = (echo.id & ~CAN_SFF_MASK) | ((echo.id + 1) & CAN_SFF_MASK);
  to_host_.push_back(echo);
  to_host_.push_back(answer);
}

void EmulatedGsUsb::bus_frame(std::uint32_t id, ByteSpan data) {
  if (!started_) return;
  Packet packet{.echo = kNoEcho,
                .id = id,
                .dlc = static_cast<std::uint8_t>(std::min<std::size_t>(data.size(), 8)),
                .data = {}};
  std::copy_n(data.begin(), packet.dlc, packet.data.begin());
  to_host_.push_back(packet);
}

// Error frames as linux/can/error.h says.
void EmulatedGsUsb::set_bus_state(BusState state) {
  state_ = state;
  if (!started_) return;
  Packet packet{.echo = kNoEcho, .id = CAN_ERR_FLAG | CAN_ERR_CRTL, .dlc = CAN_ERR_DLC, .data = {}};
  switch (state) {
    case BusState::kActive:
      packet.data[1] = CAN_ERR_CRTL_ACTIVE;
      break;
    case BusState::kWarning:
      packet.data[1] = CAN_ERR_CRTL_TX_WARNING;
      break;
    case BusState::kPassive:
      packet.data[1] = CAN_ERR_CRTL_TX_PASSIVE;
      break;
    case BusState::kBusOff:
      packet.id = CAN_ERR_FLAG | CAN_ERR_BUSOFF;
      break;
  }
  to_host_.push_back(packet);
}

std::optional<Bytes> EmulatedGsUsb::send(std::uint8_t endpoint, std::size_t room) {
  if (endpoint != kIn || held_ || to_host_.empty()) return std::nullopt;
  const Packet packet = to_host_.front();
  to_host_.pop_front();
  if (packet.echo != kNoEcho) --in_flight_;
  Bytes bytes = encode(packet, std::exchange(fault_, Fault::kNone));
  bytes.resize(std::min(bytes.size(), room));
  return bytes;
}

Bytes EmulatedGsUsb::encode(const Packet& packet, Fault fault) const {
  Bytes bytes = words({fault == Fault::kUnknownEcho ? kUnknownEcho : packet.echo, packet.id});
  bytes.resize(kDataAt);
  bytes[kDlcAt] = fault == Fault::kWrongDlc ? std::uint8_t{9} : packet.dlc;
  bytes[kChannelAt] = fault == Fault::kWrongChannel ? 3 : 0;
  bytes[kFlagsAt] = fault == Fault::kOverflow ? kOverflowFlag : 0;
  bytes.insert(bytes.end(), packet.data.begin(), packet.data.end());
  if (stamped_) append_le(bytes, microseconds(), kStampSize);
  if (fault == Fault::kHalf) bytes.resize(kFrameSize / 2);
  if (fault == Fault::kLong) bytes.resize(64);
  return bytes;
}

// Wraps after 71.6 minutes, as the real one does.
std::uint32_t EmulatedGsUsb::microseconds() const {
  return static_cast<std::uint32_t>(clock_.now().time_since_epoch().count() / 1000);
}

}  // namespace headway::hil
