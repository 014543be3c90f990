#include "config/yaml_limits.h"

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

std::string one_line(std::string text, std::size_t longest) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  if (text.size() <= longest) return text;
  // Not in the middle of a UTF-8 character.
  while (longest > 0 && (static_cast<unsigned char>(text[longest]) & 0xC0U) == 0x80U) --longest;
  return text.substr(0, longest) + "...";
}

}  // namespace headway::config
