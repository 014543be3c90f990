// A file read piece by piece: no size that it claims is believed before its bytes are there, and every
// complaint names it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>

namespace headway::nav {

class ByteReader {
 public:
  /// `file` is only named in complaints.
  ByteReader(std::istream& in, std::string file);

  /// Throws InputError `file: what`.
  [[noreturn]] void fail(const std::string& what) const;

  bool at_end() const { return in_.sgetc() == std::char_traits<char>::eof(); }
  /// Throws InputError at the end of the file, as all below.
  std::uint8_t byte() {
    const int c = in_.sbumpc();
    if (c == std::char_traits<char>::eof()) end_too_early();
    return static_cast<std::uint8_t>(c);
  }
  void bytes(char* into, std::size_t count);
  /// Little-endian.
  std::uint32_t word() {
    const std::uint32_t b0 = byte(), b1 = byte(), b2 = byte(), b3 = byte();
    return b0 | b1 << 8 | b2 << 16 | b3 << 24;
  }
  /// Up to the end of the line, without it. Fails also where a line is longer than any of a text header.
  std::string line();
  /// The next word between white space, for text files. Fails as `line`.
  std::string token();

 private:
  [[noreturn]] void end_too_early() const;

  std::streambuf& in_;
  std::string file_;
};

/// A whole number or a decimal one, all of the text; false, and `value` is open, when it is none. Numbers
/// that are not finite are read as such.
bool parse_number(const std::string& text, std::uint64_t& value);
bool parse_number(const std::string& text, double& value);

}  // namespace headway::nav
