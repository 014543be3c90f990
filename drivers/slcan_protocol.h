// The lines that a serial CAN adapter and its computer exchange: Lawicel's ASCII protocol (CANUSB manual,
// "Available CANUSB ASCII commands"), which Linux calls slcan.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "hal/can_bus.h"

namespace headway::drivers {

/// One line to an adapter, with the carriage return that ends it.
class SlcanLine {
 public:
  /// tIIILDD..: a data frame with an 11-bit identifier and at most 8 bytes.
  explicit SlcanLine(const hal::CanFrame& frame) noexcept;
  std::string_view text() const noexcept { return {text_.data(), size_}; }

 private:
  std::array<char, 22> text_{};
  std::size_t size_ = 0;
};

/// Takes an adapter's bytes one by one. What makes no sense counts as unusable up to the next carriage
/// return.
class SlcanReader {
 public:
  enum class Event : std::uint8_t {
    kNone,      ///< within a line
    kFrame,     ///< frame() has come
    kUnusable,  ///< a remote frame, one with a 29-bit identifier, or no line of the protocol
    kDone,      ///< the adapter did what it was told
    kRefused,   ///< the adapter could not (BEL)
  };
  Event feed(char byte) noexcept;
  /// The frame that came last, without a stamp.
  const hal::CanFrame& frame() const noexcept { return frame_; }

 private:
  Event end_of(std::string_view line) noexcept;
  bool read_frame(std::string_view line) noexcept;

  std::array<char, 30> line_{};  // the longest: T, 8 digits, length, 16 digits of data, 4 of a stamp
  std::size_t size_ = 0;         // of the line; more than fits it: too long a one
  hal::CanFrame frame_;
};

}  // namespace headway::drivers
