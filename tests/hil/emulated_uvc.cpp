#include "tests/hil/emulated_uvc.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "hal/error.h"
#include "tests/hil/uvc_descriptors.h"

namespace headway::hil {
namespace {

using namespace uvc;

// Requests, tables A-8; the selectors of the streaming interface, A-15.
constexpr std::uint8_t kSetCurrent = 0x01, kGetCurrent = 0x81, kGetLowest = 0x82, kGetHighest = 0x83,
                       kGetResolution = 0x84, kGetLength = 0x85, kGetInfo = 0x86, kGetInitial = 0x87;
constexpr std::uint8_t kProbe = 1, kCommit = 2;
constexpr std::uint8_t kCanGetAndSet = 3;

// The probe and commit control, table 4-47.
constexpr std::size_t kProbeSize = 26, kIntervalAt = 4, kFrameSizeAt = 18;

// A payload's header, 2.4.3.2.
constexpr std::uint8_t kHeaderSize = 2, kEndOfHeader = 0x80, kEndOfFrame = 0x02;

constexpr std::array<UvcControl, 6> kControls{{
    {.entity = kCameraTerminal,
     .selector = 2,
     .lowest = 1,
     .highest = 8,
     .resolution = 9,
     .initial = 8},  // exposure mode
    {.entity = kCameraTerminal,
     .selector = 4,
     .size = 4,
     .lowest = 1,
     .highest = 5000,
     .initial = 156},                                                                       // exposure time
    {.entity = kProcessingUnit, .selector = 2, .size = 2, .highest = 255, .initial = 128},  // brightness
    {.entity = kProcessingUnit, .selector = 4, .size = 2, .highest = 64, .initial = 16},    // gain
    {.entity = kProcessingUnit,
     .selector = 0x0A,
     .size = 2,
     .lowest = 2800,
     .highest = 6500,
     .initial = 4600},
    {.entity = kProcessingUnit, .selector = 0x0B, .highest = 1, .initial = 1},  // automatic white balance
}};

Bytes little_endian(std::uint32_t value, std::size_t size) {
  Bytes bytes;
  append_le(bytes, value, size);
  return bytes;
}

}  // namespace

std::uint32_t EmulatedUvc::Config::frame_size() const {
  return std::uint32_t{width} * height * (format == Format::kGrey ? 1 : 2);
}

void EmulatedUvc::Config::validate() const {
  if (width == 0 || height == 0 || width % 2 != 0) {
    throw InputError(
        fmt::format("frames of {}x{}; expected an even width and a height from 1", width, height));
  }
}

EmulatedUvc::EmulatedUvc(const Config& config, FrameSource source, const hal::Clock& clock)
    : config_(config),
      source_(std::move(source)),
      clock_(clock),
      description_(describe(config)),
      controls_(kControls),
      interval_(kIntervals.front()) {
  config_.validate();
}

void EmulatedUvc::power_on() {
  controls_ = kControls;
  interval_ = kIntervals.front();
  streaming_ = paused_ = cut_ = false;
  frame_.clear();
}

// A bulk stream has no request that ends it: the host clears the endpoint's halt instead.
void EmulatedUvc::halt_cleared(std::uint8_t endpoint) {
  if (endpoint != kIn) return;
  streaming_ = false;
  frame_.clear();
}

std::optional<Bytes> EmulatedUvc::request(const SetupPacket& setup, ByteSpan sent) {
  const bool to_streaming = (setup.index & 0xFF) == kStreamingInterface;
  return to_streaming ? request_streaming(setup, sent) : request_control(setup, sent);
}

std::optional<Bytes> EmulatedUvc::request_streaming(const SetupPacket& setup, ByteSpan sent) {
  const int selector = setup.value >> 8;
  if (selector != kProbe && selector != kCommit) return std::nullopt;
  switch (setup.request) {
    case kSetCurrent: {
      const std::uint32_t wanted = read_le(sent, kIntervalAt, 4);
      const bool offered = std::find(kIntervals.begin(), kIntervals.end(), wanted) != kIntervals.end();
      interval_ = offered ? wanted : kIntervals.front();
      if (selector == kCommit) start();
      return Bytes{};
    }
    case kGetLength:
      return little_endian(kProbeSize, 2);
    case kGetInfo:
      return Bytes{kCanGetAndSet};
    case kGetCurrent:
    case kGetLowest:
    case kGetHighest:
    case kGetInitial:
      return negotiated();
    default:
      return std::nullopt;
  }
}

Bytes EmulatedUvc::negotiated() const {
  Bytes bytes{1, 0, 1, 1};  // the interval stands; first format, first size
  append_le(bytes, interval_, 4);
  bytes.resize(kFrameSizeAt);
  append_le(bytes, config_.frame_size(), 4);
  append_le(bytes, kPayloadSize, 4);
  return bytes;
}

std::optional<Bytes> EmulatedUvc::request_control(const SetupPacket& setup, ByteSpan sent) {
  const auto control = std::find_if(controls_.begin(), controls_.end(), [&](const UvcControl& c) {
    return c.entity == setup.index >> 8 && c.selector == setup.value >> 8;
  });
  if (control == controls_.end()) return std::nullopt;
  switch (setup.request) {
    case kSetCurrent:
      control->value = std::clamp(read_le(sent, 0, control->size), control->lowest, control->highest);
      return Bytes{};
    case kGetCurrent:
      return little_endian(control->value, control->size);
    case kGetLowest:
      return little_endian(control->lowest, control->size);
    case kGetHighest:
      return little_endian(control->highest, control->size);
    case kGetResolution:
      return little_endian(control->resolution, control->size);
    case kGetInitial:
      return little_endian(control->initial, control->size);
    case kGetLength:
      return little_endian(control->size, 2);
    case kGetInfo:
      return Bytes{kCanGetAndSet};
    default:
      return std::nullopt;
  }
}

void EmulatedUvc::receive(std::uint8_t, ByteSpan) {}

void EmulatedUvc::start() {
  streaming_ = true;
  frame_.clear();
  due_ = clock_.now();
}

std::optional<Time> EmulatedUvc::due() const {
  if (!streaming_ || paused_) return std::nullopt;
  return frame_.empty() ? due_ : clock_.now();
}

std::optional<Bytes> EmulatedUvc::send(std::uint8_t endpoint, std::size_t room) {
  if (endpoint != kIn || !streaming_ || room <= kHeaderSize) return std::nullopt;
  if (frame_.empty()) {
    if (paused_ || clock_.now() < due_) return std::nullopt;
    begin_frame();
  }
  const std::size_t most = std::min<std::size_t>(room, kPayloadSize) - kHeaderSize;
  const std::size_t count = std::min(most, frame_.size() - sent_);
  const bool last = sent_ + count == frame_.size();

  Bytes payload{kHeaderSize,
                static_cast<std::uint8_t>(kEndOfHeader | frame_parity_ | (last ? kEndOfFrame : 0))};
  const auto begin = frame_.begin() + static_cast<std::ptrdiff_t>(sent_);
  payload.insert(payload.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
  sent_ += count;
  if (last) end_frame();
  return payload;
}

void EmulatedUvc::begin_frame() {
  const ByteSpan frame = source_();
  frame_.assign(frame.begin(), frame.end());
  if (config_.format != Config::Format::kMjpeg) frame_.resize(config_.frame_size());
  if (std::exchange(cut_, false)) frame_.resize(frame_.size() / 2);
  sent_ = 0;
}

// A host that is too slow gets fewer frames, never a burst of them.
void EmulatedUvc::end_frame() {
  frame_.clear();
  frame_parity_ ^= 1;
  due_ = std::max(due_ + Duration(std::int64_t{interval_} * 100), clock_.now());
}

}  // namespace headway::hil
