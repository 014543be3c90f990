// Values as they lie in MCAP's records: little-endian, texts and lists behind their length in bytes.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "hal/time.h"
#include "runtime/recording/mcap_format.h"

namespace headway::recording {

/// Appends values to a list of bytes.
class RecordWriter {
 public:
  explicit RecordWriter(std::vector<std::byte>& bytes) : bytes_(bytes) {}

  template <std::integral T>
  RecordWriter& put(T value) {
    return raw({reinterpret_cast<const std::byte*>(&value), sizeof value});
  }
  RecordWriter& put(Time t) { return put(static_cast<std::uint64_t>(t.time_since_epoch().count())); }
  RecordWriter& put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    return raw(std::as_bytes(std::span(text)));
  }
  RecordWriter& put(const std::string& text) { return put(std::string_view(text)); }
  template <class Key, class Value>
  RecordWriter& put(const std::map<Key, Value>& values) {
    const std::size_t at = begin_length();
    for (const auto& [key, value] : values) put(key).put(value);
    return end_length(at);
  }
  RecordWriter& raw(std::span<const std::byte> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }

  /// A list's length in bytes (32 bit) is filled in when its values are there.
  std::size_t begin_length() {
    put(std::uint32_t{0});
    return bytes_.size();
  }
  RecordWriter& end_length(std::size_t at) {
    const auto size = static_cast<std::uint32_t>(bytes_.size() - at);
    std::memcpy(bytes_.data() + at - sizeof size, &size, sizeof size);
    return *this;
  }
  /// The same for a whole record (64 bit).
  std::size_t begin_record(Op op) {
    put(static_cast<std::uint8_t>(op)).put(std::uint64_t{0});
    return bytes_.size();
  }
  RecordWriter& end_record(std::size_t at) {
    const std::uint64_t size = bytes_.size() - at;
    std::memcpy(bytes_.data() + at - sizeof size, &size, sizeof size);
    return *this;
  }

 private:
  std::vector<std::byte>& bytes_;
};

/// Thrown where a record ends too soon.
class RecordError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Takes values from the front of a record's content. Throws RecordError where it ends too soon.
class RecordReader {
 public:
  explicit RecordReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <std::integral T>
  T number() {
    T value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  Time time() { return Time(Duration(static_cast<Duration::rep>(number<std::uint64_t>()))); }
  std::string text() {
    const auto bytes = take(number<std::uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  /// The bytes of a list whose length (32 bit) stands before it.
  RecordReader list() { return RecordReader(take(number<std::uint32_t>())); }
  std::span<const std::byte> take(std::uint64_t size) {
    if (size > bytes_.size()) throw RecordError("ends too soon");
    const auto front = bytes_.first(static_cast<std::size_t>(size));
    bytes_ = bytes_.subspan(front.size());
    return front;
  }
  std::span<const std::byte> rest() const { return bytes_; }
  bool empty() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace headway::recording
