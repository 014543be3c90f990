// Checked reading of YAML: every value has a key, a range and a unit, and every fault names file, line and
// key.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "hal/error.h"

namespace headway::config {

/// Closed interval of allowed values, with the unit for messages.
struct Range {
  double lowest, highest;
  std::string_view unit = "";
};

/// One mapping of a YAML file. Reading a key marks it as known; `finish` refuses the rest, so that a misspelt
/// key is an error and not a silent default. Throws InputError: `file:line: key: what, expected what`.
class Section {
 public:
  /// Reads a whole file. `what` names its kind for messages ("world", "rig").
  static Section load(const std::filesystem::path& file, std::string_view what);
  /// The same from text; `file` is only named in messages.
  static Section parse(const std::string& text, const std::string& file);

  bool has(std::string_view key) const;

  double number(std::string_view key, Range allowed) const;
  double number_or(std::string_view key, double fallback, Range allowed) const;
  int integer(std::string_view key, Range allowed) const;
  int integer_or(std::string_view key, int fallback, Range allowed) const;
  bool flag_or(std::string_view key, bool fallback) const;
  std::string text(std::string_view key) const;
  std::string text_or(std::string_view key, std::string_view fallback) const;
  /// One of a fixed set of words.
  std::string choice(std::string_view key, const std::vector<std::string>& allowed) const;
  std::string choice_or(std::string_view key, std::string_view fallback,
                        const std::vector<std::string>& allowed) const;
  /// Exactly `count` numbers in a list.
  std::vector<double> numbers(std::string_view key, std::size_t count, Range allowed) const;
  /// From `least` to `most` numbers in a list.
  std::vector<double> numbers_between(std::string_view key, std::size_t least, std::size_t most,
                                      Range allowed) const;
  /// A list of `rows` lists of `columns` numbers, row by row.
  std::vector<double> matrix(std::string_view key, std::size_t rows, std::size_t columns,
                             Range allowed) const;
  std::optional<std::vector<double>> numbers_if(std::string_view key, std::size_t count, Range allowed) const;

  /// A mapping below this one. `section` requires it; `section_if` returns nothing when absent.
  Section section(std::string_view key) const;
  std::optional<Section> section_if(std::string_view key) const;
  /// A list of mappings; empty when absent.
  std::vector<Section> sections(std::string_view key) const;

  /// A path in the file, relative to the file's own folder.
  std::filesystem::path path(std::string_view key) const;

  /// Refuses keys that nobody asked for, here and in all sections read from here.
  void finish() const;

  /// Throws InputError at a key of this section (or at the section itself when the key is absent).
  [[noreturn]] void fail(std::string_view key, const std::string& what) const;

  const std::string& file() const { return file_; }
  /// file:line of it.
  std::string place() const;

 private:
  struct Seen;
  Section(YAML::Node node, std::string file, std::string name, std::shared_ptr<Seen> seen);
  YAML::Node child(std::string_view key) const;
  YAML::Node required(std::string_view key) const;
  double checked_number(std::string_view key, const YAML::Node& node, Range allowed) const;
  std::string full_name(std::string_view key) const;

  YAML::Node node_;
  std::string file_, name_;
  std::shared_ptr<Seen> seen_;
};

}  // namespace headway::config
