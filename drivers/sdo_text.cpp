#include "drivers/sdo_text.h"

#include <algorithm>

#include "hal/cia402.h"

namespace headway::drivers {

namespace {

namespace sdo = hal::cia402::sdo;

// The first byte of an answer.
constexpr std::uint8_t kSpecifier = 0xE0, kUploaded = 0x40, kSegment = 0x00;
constexpr std::uint8_t kExpedited = 0x02, kSizeTold = 0x01;  // of the beginning
constexpr std::uint8_t kToggle = 0x10, kLast = 0x01;         // of a segment
constexpr std::uint8_t kAskSegment = 0x60;

}  // namespace

void SdoText::read(std::uint16_t index) noexcept {
  status_ = Status::kBusy;
  index_ = index;
  size_ = 0;
  in_segments_ = toggle_ = false;
  ask({sdo::kUpload, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8)});
}

void SdoText::ask(std::array<std::uint8_t, 8> request) noexcept {
  request_ = request;
  sent_.reset();
  tries_left_ = config_.tries;
}

void SdoText::tick(Time now) noexcept {
  if (status_ != Status::kBusy || (sent_ && now - *sent_ < config_.timeout)) return;
  // A segment is not asked for twice: had the answer got lost, the node would be one ahead.
  if (tries_left_ <= 0 || (sent_ && in_segments_)) {
    status_ = Status::kTimedOut;
    if (in_segments_) abort_transfer();
  } else if (bus_.send(
                 {.id = hal::cia402::kSdoRequestBase + node_, .dlc = 8, .data = request_, .stamp = {}})) {
    sent_ = now;
    --tries_left_;
  }
}

/// The node must not wait for us in mid-transfer (CiA 301, 7.2.4.3.17: 0504 0000, SDO protocol timed out).
void SdoText::abort_transfer() noexcept {
  bus_.send({.id = hal::cia402::kSdoRequestBase + node_,
             .dlc = 8,
             .data = {sdo::kAbort, static_cast<std::uint8_t>(index_), static_cast<std::uint8_t>(index_ >> 8),
                      0, 0x00, 0x00, 0x04, 0x05},
             .stamp = {}});
}

void SdoText::receive(const hal::CanFrame& frame) noexcept {
  if (status_ != Status::kBusy || !sent_ || frame.id != hal::cia402::kSdoAnswerBase + node_ || frame.dlc != 8)
    return;
  if (frame.data[0] == sdo::kAbort) {
    if ((frame.data[1] | frame.data[2] << 8) == index_) status_ = Status::kRefused;
  } else if (in_segments_) {
    take_segment(frame);
  } else {
    take_beginning(frame);
  }
}

void SdoText::take_beginning(const hal::CanFrame& frame) noexcept {
  const std::uint8_t command = frame.data[0];
  if ((command & kSpecifier) != kUploaded || (frame.data[1] | frame.data[2] << 8) != index_ ||
      frame.data[3] != 0)
    return;
  if ((command & kExpedited) != 0) {
    append(&frame.data[4], (command & kSizeTold) != 0 ? 4 - (command >> 2 & 3) : 4);
    status_ = Status::kDone;
  } else {
    in_segments_ = true;
    ask({kAskSegment});
  }
}

void SdoText::take_segment(const hal::CanFrame& frame) noexcept {
  const std::uint8_t command = frame.data[0];
  if ((command & kSpecifier) != kSegment || ((command & kToggle) != 0) != toggle_) return;
  append(&frame.data[1], 7 - (command >> 1 & 7));
  if ((command & kLast) != 0) {
    status_ = Status::kDone;
  } else {
    toggle_ = !toggle_;
    ask({static_cast<std::uint8_t>(kAskSegment | (toggle_ ? kToggle : 0))});
  }
}

void SdoText::append(const std::uint8_t* bytes, std::size_t count) noexcept {
  count = std::min(count, kMost - size_);
  std::copy_n(bytes, count, text_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += count;
}

std::string_view SdoText::text() const noexcept {
  const std::string_view all(text_.data(), size_);
  return all.substr(0, all.find('\0'));
}

}  // namespace headway::drivers
