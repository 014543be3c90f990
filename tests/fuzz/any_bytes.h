// The bytes of a fuzzer's input, read from the front as whatever a test needs of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace headway::fuzz {

class AnyBytes {
 public:
  explicit AnyBytes(std::string_view bytes) : left_(bytes) {}

  bool empty() const { return left_.empty(); }
  /// The next one; 0 once all are read.
  std::uint8_t byte() {
    if (left_.empty()) return 0;
    const auto next = static_cast<std::uint8_t>(left_.front());
    left_.remove_prefix(1);
    return next;
  }
  /// Two bytes, the low one first.
  std::uint16_t word() {
    const std::uint8_t low = byte();
    return static_cast<std::uint16_t>(low | byte() << 8);
  }
  std::int16_t number() { return static_cast<std::int16_t>(word()); }
  std::array<std::uint8_t, 8> data() {
    std::array<std::uint8_t, 8> all{};
    for (std::uint8_t& one : all) one = byte();
    return all;
  }
  /// One of these.
  template <class T, std::size_t n>
  const T& one_of(const std::array<T, n>& these) {
    return these[byte() % n];
  }
  /// Up to `end`, which is read and left out, or to the last.
  std::string_view until(char end) {
    const std::string_view part = left_.substr(0, left_.find(end));
    left_.remove_prefix(std::min(left_.size(), part.size() + 1));
    return part;
  }

 private:
  std::string_view left_;
};

/// The other way round: an input as text.
class Input {
 public:
  Input& byte(int value) {
    text_ += static_cast<char>(value);
    return *this;
  }
  Input& word(int value) { return byte(value & 0xFF).byte(value >> 8 & 0xFF); }
  Input& data(const std::array<std::uint8_t, 8>& all) {
    for (const std::uint8_t one : all) byte(one);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace headway::fuzz
