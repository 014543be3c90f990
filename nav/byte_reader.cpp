#include "nav/byte_reader.h"

#include <cctype>
#include <charconv>
#include <utility>

#include "hal/error.h"

namespace headway::nav {
namespace {

constexpr std::size_t kLongestLine = 1000;

template <class Number>
bool parse(const std::string& text, Number& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace

ByteReader::ByteReader(std::istream& in, std::string file) : in_(*in.rdbuf()), file_(std::move(file)) {}

void ByteReader::fail(const std::string& what) const { throw InputError(file_ + ": " + what); }

void ByteReader::end_too_early() const { fail("ends too early; copy it again"); }

void ByteReader::bytes(char* into, std::size_t count) {
  const auto wanted = static_cast<std::streamsize>(count);
  if (in_.sgetn(into, wanted) != wanted) end_too_early();
}

std::string ByteReader::line() {
  std::string text;
  for (char c = static_cast<char>(byte()); c != '\n'; c = static_cast<char>(byte())) {
    if (text.size() == kLongestLine) fail("a line of the header is longer than 1000 bytes");
    text += c;
  }
  if (text.ends_with('\r')) text.pop_back();
  return text;
}

std::string ByteReader::token() {
  int c = byte();
  while (std::isspace(c)) c = byte();
  std::string text;
  while (!std::isspace(c)) {
    if (text.size() == kLongestLine) fail("a word is longer than 1000 bytes");
    text += static_cast<char>(c);
    if (at_end()) break;
    c = byte();
  }
  return text;
}

bool parse_number(const std::string& text, std::uint64_t& value) { return parse(text, value); }
bool parse_number(const std::string& text, double& value) { return parse(text, value); }

}  // namespace headway::nav
