#include "hal/bus_protection.h"

#include <algorithm>
#include <array>

namespace headway::hal::bus {
namespace {

constexpr int kCounters = 15;  // 0..14; 15 never travels

}  // namespace

std::uint8_t frame_crc(const CanFrame& frame, std::uint16_t data_id) noexcept {
  const std::array<std::uint8_t, 2> id{static_cast<std::uint8_t>(data_id),
                                       static_cast<std::uint8_t>(data_id >> 8)};
  const std::size_t length = std::clamp<std::size_t>(frame.dlc, 1, frame.data.size());
  return crc8(std::span(frame.data).subspan(1, length - 1), crc8(id));
}

void Protector::protect(CanFrame& frame) noexcept {
  frame.data[1] = static_cast<std::uint8_t>((frame.data[1] & 0xF0) | counter_);
  frame.data[0] = frame_crc(frame, data_id_);
  counter_ = static_cast<std::uint8_t>((counter_ + 1) % kCounters);
}

Check ProtectionChecker::check(const CanFrame& frame) noexcept {
  const int counter = frame.data[1] & 0x0F;
  if (frame.dlc < 2 || counter >= kCounters || frame.data[0] != frame_crc(frame, data_id_)) {
    ++counts_.wrong_crc;
    return Check::kWrongCrc;
  }
  const int delta = last_ ? (counter - *last_ + kCounters) % kCounters : 1;
  if (delta == 0) {
    ++counts_.repeated;
    return Check::kRepeated;
  }
  last_ = static_cast<std::uint8_t>(counter);
  if (delta > max_delta_) {
    ++counts_.wrong_sequence;
    return Check::kWrongSequence;
  }
  ++counts_.ok;
  counts_.lost += static_cast<std::uint32_t>(delta - 1);
  return delta == 1 ? Check::kOk : Check::kOkSomeLost;
}

}  // namespace headway::hal::bus
