#include "config/yaml_limits.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "hal/error.h"

namespace headway::config {

namespace {

std::string place(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : fmt::format("{}:{}", file, mark.line + 1);
}

// Hears the parser's events and keeps count; nothing is stored, so a huge text costs time but no memory.
class Census final : public YAML::EventHandler {
 public:
  Census(const std::string& file, const YamlLimits& limits) : file_(file), limits_(limits) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1)
      throw InputError(fmt::format("{}: more text after the end of the mapping, expected one document",
                                   place(file_, mark)));
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { count(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { count(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string&) override {
    count(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    descend(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    descend(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void count(const YAML::Mark& mark) {
    if (++values_ > limits_.values)
      throw InputError(fmt::format("{}: too much, expected at most {} values in a file", place(file_, mark),
                                   limits_.values));
  }
  void descend(const YAML::Mark& mark) {
    count(mark);
    if (++depth_ > limits_.depth)
      throw InputError(
          fmt::format("{}: nested too deep, expected at most {} mappings and lists inside each other",
                      place(file_, mark), limits_.depth));
  }

  std::string file_;
  YamlLimits limits_;
  std::size_t documents_ = 0, values_ = 0, depth_ = 0;
};

/// Bytes of the UTF-8 character that `text` begins with (RFC 3629); 0 where it begins with none.
std::size_t length_of_first(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(i < text.size() ? text[i] : 0); };
  const auto goes_on = [&](std::size_t from, std::size_t to) {
    for (; from < to; ++from)
      if ((byte(from) & 0xC0U) != 0x80U) return false;
    return true;
  };
  const unsigned first = byte(0), second = byte(1);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return goes_on(1, 2) ? 2 : 0;
  // Neither longer than need be, nor a surrogate, nor beyond U+10FFFF.
  const bool fits = !(first == 0xE0 && second < 0xA0) && !(first == 0xED && second > 0x9F) &&
                    !(first == 0xF0 && second < 0x90) && !(first == 0xF4 && second > 0x8F);
  if (first >= 0xE0 && first < 0xF0) return fits && goes_on(1, 3) ? 3 : 0;
  if (first >= 0xF0 && first < 0xF5) return fits && goes_on(1, 4) ? 4 : 0;
  return 0;
}

/// U+0080 to U+009F are controls as well: terminals obey what U+009B begins.
bool is_control(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  return first < 0x20 || first == 0x7F || (first == 0xC2 && static_cast<unsigned char>(character[1]) < 0xA0);
}

}  // namespace

void check_yaml(const std::string& text, const std::string& file, const YamlLimits& limits) {
  if (text.size() > limits.bytes)
    throw InputError(fmt::format("{}: {} bytes, expected at most {}", file, text.size(), limits.bytes));
  if (text.find('\0') != std::string::npos)
    throw InputError(fmt::format("{}: not a text file, expected YAML", file));
  std::istringstream in(text);
  Census census(file, limits);
  try {
    YAML::Parser parser(in);
    while (parser.HandleNextDocument(census)) {
    }
  } catch (const YAML::Exception& e) {
    throw InputError(
        fmt::format("{}: not valid YAML: {}; look there and above for an open bracket or quote, or a line "
                    "that is indented otherwise",
                    place(file, e.mark), one_line(e.msg)));
  }
}

bool is_utf8(std::string_view text) {
  for (std::size_t length = 0; !text.empty(); text.remove_prefix(length))
    if (length = length_of_first(text); length == 0) return false;
  return true;
}

std::string one_line(const std::string& text, std::size_t longest) {
  std::string line;
  for (std::string_view left = text; !left.empty();) {
    const std::size_t length = length_of_first(left);
    const std::string_view first = left.substr(0, std::max<std::size_t>(length, 1));
    const std::string_view shown = length == 0 ? "?" : is_control(first) ? " " : first;
    if (line.size() + shown.size() > longest) return line + "...";
    line += shown;
    left.remove_prefix(first.size());
  }
  return line;
}

}  // namespace headway::config
