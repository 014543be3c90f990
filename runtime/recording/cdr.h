// ROS 2 messages as plain structs, in CDR (OMG formal/02-06-51, 15.3; little-endian, as every ROS 2
// middleware reads it), and the text that describes them (ros2msg). All three come from one list of a
// struct's fields.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace headway::recording {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie in memory");

/// A message is an aggregate with its name, like "std_msgs/msg/Header", and its fields in order:
///   static constexpr std::string_view kName;
///   static void fields(auto& self, auto&& visit) { visit("stamp", self.stamp); ... }
/// Fields may be numbers, bool, std::string, messages, and std::array, std::vector or (written only)
/// std::span of these.
template <class T>
concept CdrMessage = requires {
  { T::kName } -> std::convertible_to<std::string_view>;
};

/// Thrown for bytes that are no such message.
class CdrError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

namespace cdr {

/// CDR_LE, no options.
inline constexpr std::array<std::byte, 4> kHeader{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};

template <class T>
concept Number = std::is_arithmetic_v<T>;

template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};
template <class T>
struct IsSequence : std::false_type {};
template <class T>
struct IsSequence<std::vector<T>> : std::true_type {};
template <class T>
struct IsSequence<std::span<const T>> : std::true_type {};

/// Appends to `bytes`; what is aligned is so from where the message begins, behind its header.
class Writer {
 public:
  explicit Writer(std::vector<std::byte>& bytes) : bytes_(bytes), begin_(bytes.size()) {}

  template <Number T>
  void put(T value) {
    align(sizeof(T));
    append(&value, sizeof value);
  }
  void put(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    append(text.c_str(), text.size() + 1);
  }
  template <CdrMessage T>
  void put(const T& message) {
    T::fields(message, [this](const char*, const auto& field) { this->put(field); });
  }
  template <class T>
  requires(IsArray<T>::value || IsSequence<T>::value) void put(const T& values) {
    using Value = std::remove_const_t<std::remove_reference_t<decltype(*values.data())>>;
    if constexpr (IsSequence<T>::value) put(static_cast<std::uint32_t>(values.size()));
    if constexpr (Number<Value>) {
      if (values.empty()) return;
      align(sizeof(Value));
      append(values.data(), values.size() * sizeof(Value));
    } else {
      for (const Value& value : values) put(value);
    }
  }

 private:
  void align(std::size_t size) {
    while ((bytes_.size() - begin_) % size != 0) bytes_.push_back(std::byte{0});
  }
  void append(const void* from, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(from);
    bytes_.insert(bytes_.end(), first, first + size);
  }

  std::vector<std::byte>& bytes_;
  std::size_t begin_;
};

/// Takes values from the front. Throws CdrError where the bytes end too soon; what a length promises is not
/// allocated before it is there.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <Number T>
  void get(T& value) {
    align(sizeof(T));
    if constexpr (std::is_same_v<T, bool>)
      value = take(1)[0] != std::byte{0};
    else
      std::memcpy(&value, take(sizeof value).data(), sizeof value);
  }
  void get(std::string& text) {
    const std::size_t size = length();
    const auto bytes = take(size);
    if (size == 0) throw CdrError("a text without its end");
    text.assign(reinterpret_cast<const char*>(bytes.data()), size - 1);
  }
  template <CdrMessage T>
  void get(T& message) {
    T::fields(message, [this](const char*, auto& field) { this->get(field); });
  }
  template <class T>
  requires(IsArray<T>::value) void get(T& values) {
    for (auto& value : values) get(value);
  }
  template <class T>
  void get(std::vector<T>& values) {
    const std::size_t size = length();
    values.clear();
    if constexpr (Number<T>) {
      if (size == 0) return;
      align(sizeof(T));
      if (size > (bytes_.size() - at_) / sizeof(T)) throw CdrError("ends too soon");
      values.resize(size);
      std::memcpy(values.data(), take(size * sizeof(T)).data(), size * sizeof(T));
    } else {
      for (std::size_t i = 0; i < size; ++i) get(values.emplace_back());
    }
  }

  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::size_t length() {
    std::uint32_t size = 0;
    get(size);
    if (size > bytes_.size() - at_) throw CdrError("ends too soon");  // a value takes a byte at least
    return size;
  }
  void align(std::size_t size) { at_ = std::min(bytes_.size(), (at_ + size - 1) / size * size); }
  std::span<const std::byte> take(std::size_t size) {
    if (size > bytes_.size() - at_) throw CdrError("ends too soon");
    at_ += size;
    return bytes_.subspan(at_ - size, size);
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

/// ROS's name of a number's type.
template <Number T>
constexpr std::string_view number_name() {
  if constexpr (std::is_same_v<T, bool>) return "bool";
  if constexpr (std::is_same_v<T, float>) return "float32";
  if constexpr (std::is_same_v<T, double>) return "float64";
  constexpr std::array<std::string_view, 4> kSigned{"int8", "int16", "int32", "int64"};
  constexpr std::array<std::string_view, 4> kUnsigned{"uint8", "uint16", "uint32", "uint64"};
  constexpr std::size_t kSize = std::bit_width(sizeof(T)) - 1;
  return std::is_signed_v<T> ? kSigned[kSize] : kUnsigned[kSize];
}

/// "geometry_msgs/Point" for "geometry_msgs/msg/Point", as it stands in .msg files.
inline std::string short_name(std::string_view name) {
  const std::size_t middle = name.find("/msg/");
  return std::string(name.substr(0, middle)) + std::string(name.substr(middle + 4));
}

/// Describes a message, and those that it is made of, once each.
class Schema {
 public:
  template <CdrMessage T>
  static std::string of() {
    Schema schema;
    std::string text = schema.lines<T>();
    for (std::size_t i = 0; i < schema.parts_.size(); ++i)
      text += std::string(80, '=') + "\nMSG: " + schema.parts_[i].name + "\n" + schema.parts_[i].text;
    return text;
  }

 private:
  struct Part {
    std::string name, text;
  };

  template <CdrMessage T>
  std::string lines() {
    std::string text;
    const T example{};
    T::fields(example, [&](const char* name, const auto& field) {
      text += type<std::remove_cvref_t<decltype(field)>>() + " " + name + "\n";
    });
    return text;
  }
  template <class T>
  std::string type() {
    if constexpr (Number<T>) {
      return std::string(number_name<T>());
    } else if constexpr (std::is_same_v<T, std::string>) {
      return "string";
    } else if constexpr (IsArray<T>::value) {
      return type<typename T::value_type>() + "[" + std::to_string(std::tuple_size_v<T>) + "]";
    } else if constexpr (IsSequence<T>::value) {
      return type<std::remove_const_t<typename T::value_type>>() + "[]";
    } else {
      return part<T>();
    }
  }
  template <CdrMessage T>
  std::string part() {
    const std::string name = short_name(T::kName);
    for (const Part& known : parts_)
      if (known.name == name) return name;
    const std::size_t place = parts_.size();
    parts_.push_back({name, {}});
    std::string text = lines<T>();
    parts_[place].text = std::move(text);
    return name;
  }

  std::vector<Part> parts_;
};

}  // namespace cdr

/// Appends the message with its CDR header.
template <CdrMessage T>
void append_cdr(const T& message, std::vector<std::byte>& bytes) {
  bytes.insert(bytes.end(), cdr::kHeader.begin(), cdr::kHeader.end());
  cdr::Writer(bytes).put(message);
}
template <CdrMessage T>
std::vector<std::byte> to_cdr(const T& message) {
  std::vector<std::byte> bytes;
  append_cdr(message, bytes);
  return bytes;
}

/// Throws CdrError where the bytes are no such message in little-endian CDR, or something follows it.
template <CdrMessage T>
T from_cdr(std::span<const std::byte> bytes) {
  if (bytes.size() < 4 || bytes[0] != std::byte{0} || bytes[1] != std::byte{1})
    throw CdrError("does not begin as little-endian CDR");
  T message{};
  cdr::Reader reader(bytes.subspan(4));
  reader.get(message);
  if (!reader.at_end()) throw CdrError("is longer than such a message");
  return message;
}

/// The ros2msg text of a message and of all that it is made of.
template <CdrMessage T>
std::string ros2msg() {
  return cdr::Schema::of<T>();
}

}  // namespace headway::recording
