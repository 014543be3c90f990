#include "config/yaml_reader.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>
#include <sstream>
#include <unordered_map>

#include <fmt/format.h>

#include "config/spelling.h"
#include "config/yaml_limits.h"

namespace headway::config {

namespace fs = std::filesystem;

namespace {

std::string place_of(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : fmt::format("{}:{}", file, mark.line + 1);
}

std::string shown(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "nothing";
  if (node.IsMap()) return "a mapping";
  if (node.IsSequence()) return "a list";
  return fmt::format("'{}'", one_line(node.Scalar(), 60));
}

// "a number from 0 to 10 m", or what of it is bounded.
std::string allowed_text(std::string_view kind, Range r) {
  std::string text(kind);
  if (std::isfinite(r.lowest) && std::isfinite(r.highest))
    text += fmt::format(" from {} to {}", r.lowest, r.highest);
  else if (std::isfinite(r.lowest))
    text += fmt::format(" of at least {}", r.lowest);
  else if (std::isfinite(r.highest))
    text += fmt::format(" of at most {}", r.highest);
  if (!r.unit.empty()) text += fmt::format(" {}", r.unit);
  return text;
}

bool is_key(const YAML::Node& node, std::string_view key) { return node.IsScalar() && node.Scalar() == key; }

bool stands_in(const YAML::Node& mapping, std::string_view key) {
  return std::any_of(mapping.begin(), mapping.end(),
                     [&](const auto& entry) { return is_key(entry.first, key); });
}

}  // namespace

// The mappings read so far, each with the keys that were asked for; shared by all sections of one file.
struct Section::Seen {
  struct Entry {
    Section section;
    Entry* parent;
    std::set<std::string, std::less<>> keys;
  };

  Entry* find(const YAML::Node& node) {
    const auto [begin, end] = by_place.equal_range(node.Mark().pos);
    for (auto it = begin; it != end; ++it)
      if (it->second->section.node_.is(node)) return it->second;
    return nullptr;
  }
  // An alias is the same mapping as its anchor: it has one entry, under whoever came first.
  Entry& find_or_add(const Section& section, Entry* parent) {
    if (Entry* known = find(section.node_)) return *known;
    Entry& entry = entries.emplace_back(Entry{section, parent, {}});
    // The entries live in `seen_`; a copy held by them must not keep it alive.
    entry.section.seen_.reset();
    by_place.emplace(section.node_.Mark().pos, &entry);
    return entry;
  }

  std::deque<Entry> entries;  // a deque, so that they stay where they are
  std::unordered_multimap<int, Entry*> by_place;
};

Section::Section(YAML::Node node, std::string file, std::string name, std::shared_ptr<Seen> seen)
    : node_(std::move(node)), file_(std::move(file)), name_(std::move(name)), seen_(std::move(seen)) {}

Section Section::load(const fs::path& file, std::string_view what) {
  std::error_code ec;
  if (fs::is_directory(file, ec))
    throw InputError(fmt::format("{}: is a folder, expected a {} file", one_line(file.string()), what));
  const fs::file_status there = fs::status(file, ec);
  if (there.type() == fs::file_type::none)
    throw InputError(fmt::format("{}: cannot be read ({}); check the path and its permissions",
                                 one_line(file.string(), 5000), ec.message()));
  if (!fs::exists(there))
    throw InputError(fmt::format("{}: no such {} file; check the path", one_line(file.string()), what));
  if (!fs::is_regular_file(there))
    throw InputError(
        fmt::format("{}: is a device or a pipe, expected a {} file", one_line(file.string()), what));
  const std::uintmax_t size = fs::file_size(file, ec);
  if (!ec && size > YamlLimits{}.bytes)
    throw InputError(fmt::format("{}: {} bytes, expected at most {} in a {} file", file.string(), size,
                                 YamlLimits{}.bytes, what));
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(fmt::format("{}: cannot be read; check its permissions", file.string()));
  std::stringstream text;
  text << in.rdbuf();
  return parse(text.str(), file.string());
}

Section Section::parse(const std::string& text, const std::string& file) {
  check_yaml(text, file);
  const YAML::Node root = YAML::Load(text);
  if (!root.IsMap())
    throw InputError(fmt::format("{}: holds {}, expected a mapping (key: value)", file, shown(root)));
  Section section(root, file, "", std::make_shared<Seen>());
  section.seen_->find_or_add(section, nullptr);
  return section;
}

std::string Section::full_name(std::string_view key) const {
  return name_.empty() ? std::string(key) : key.empty() ? name_ : fmt::format("{}.{}", name_, key);
}

void Section::fail(std::string_view key, const std::string& what) const {
  YAML::Mark mark = node_.Mark();
  if (node_.IsMap())
    for (const auto& entry : node_)
      if (is_key(entry.first, key)) mark = entry.first.Mark();
  const std::string name = one_line(full_name(key), 120);
  throw InputError(
      fmt::format("{}: {}{}{}", place_of(file_, mark), name, name.empty() ? "" : ": ", one_line(what)));
}

std::string Section::place() const { return place_of(file_, node_.Mark()); }

YAML::Node Section::child(std::string_view key) const {
  seen_->find(node_)->keys.emplace(key);
  YAML::Node found(YAML::NodeType::Undefined);
  YAML::Mark first;
  int count = 0;
  for (const auto& entry : node_)
    if (is_key(entry.first, key)) {
      if (++count > 1)
        fail(key, fmt::format("stands here twice, expected once; the first is in line {}", first.line + 1));
      found.reset(entry.second);
      first = entry.first.Mark();
    }
  return found;
}

YAML::Node Section::required(std::string_view key) const {
  YAML::Node node = child(key);
  if (node.IsDefined()) return node;
  // A key that nobody asked for, and is spelt almost alike, is meant to be this one.
  std::vector<std::string> strangers;
  for (const auto& entry : node_)
    if (entry.first.IsScalar() && !seen_->find(node_)->keys.contains(entry.first.Scalar()))
      strangers.push_back(entry.first.Scalar());
  if (const std::string typo = meant_by(key, strangers); !typo.empty())
    fail(typo, fmt::format("is not a key here, did you mean '{}'?", key));
  fail("", fmt::format("the key '{}' is missing", key));
}

bool Section::has(std::string_view key) const { return child(key).IsDefined(); }

double Section::checked_number(std::string_view key, const YAML::Node& node, Range allowed) const {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value) ||
      value < allowed.lowest || value > allowed.highest)
    fail(key, fmt::format("{}, expected {}", shown(node), allowed_text("a number", allowed)));
  return value;
}

double Section::number(std::string_view key, Range allowed) const {
  return checked_number(key, required(key), allowed);
}

double Section::number_or(std::string_view key, double fallback, Range allowed) const {
  return has(key) ? number(key, allowed) : fallback;
}

int Section::integer(std::string_view key, Range allowed) const {
  const YAML::Node node = required(key);
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || value != std::floor(value) ||
      std::abs(value) > 2e9 || value < allowed.lowest || value > allowed.highest)
    fail(key, fmt::format("{}, expected {}", shown(node), allowed_text("a whole number", allowed)));
  return static_cast<int>(value);
}

int Section::integer_or(std::string_view key, int fallback, Range allowed) const {
  return has(key) ? integer(key, allowed) : fallback;
}

bool Section::flag_or(std::string_view key, bool fallback) const {
  const YAML::Node node = child(key);
  if (!node.IsDefined()) return fallback;
  bool value = false;
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value))
    fail(key, fmt::format("{}, expected true or false", shown(node)));
  return value;
}

std::string Section::text(std::string_view key) const {
  const YAML::Node node = required(key);
  if (!node.IsScalar() || node.Scalar().empty()) fail(key, fmt::format("{}, expected a text", shown(node)));
  if (!is_utf8(node.Scalar())) fail(key, fmt::format("{}, expected a text in UTF-8", shown(node)));
  return node.Scalar();
}

std::string Section::text_or(std::string_view key, std::string_view fallback) const {
  return has(key) ? text(key) : std::string(fallback);
}

std::string Section::choice(std::string_view key, const std::vector<std::string>& allowed) const {
  std::string value = text(key);
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return value;
  const std::string meant = meant_by(value, allowed);
  fail(key, fmt::format("'{}'{}, expected one of: {}", value,
                        meant.empty() ? "" : fmt::format(" (did you mean '{}'?)", meant),
                        fmt::join(allowed, ", ")));
}

std::string Section::choice_or(std::string_view key, std::string_view fallback,
                               const std::vector<std::string>& allowed) const {
  return has(key) ? choice(key, allowed) : std::string(fallback);
}

std::vector<double> Section::numbers(std::string_view key, std::size_t count, Range allowed) const {
  return numbers_between(key, count, count, allowed);
}

std::vector<double> Section::numbers_between(std::string_view key, std::size_t least, std::size_t most,
                                             Range allowed) const {
  const YAML::Node node = required(key);
  if (!node.IsSequence() || node.size() < least || node.size() > most) {
    const std::string count = least == most ? fmt::format("{}", most) : fmt::format("{} to {}", least, most);
    fail(key, fmt::format("{}{}, expected a list of {} numbers", shown(node),
                          node.IsSequence() ? fmt::format(" of {}", node.size()) : "", count));
  }
  std::vector<double> values;
  values.reserve(node.size());
  for (const auto& item : node) values.push_back(checked_number(key, item, allowed));
  return values;
}

std::vector<double> Section::matrix(std::string_view key, std::size_t rows, std::size_t columns,
                                    Range allowed) const {
  const YAML::Node node = required(key);
  bool fits = node.IsSequence() && node.size() == rows;
  std::vector<double> values;
  values.reserve(rows * columns);
  for (std::size_t row = 0; fits && row < rows; ++row) {
    fits = node[row].IsSequence() && node[row].size() == columns;
    if (fits)
      for (const auto& item : node[row]) values.push_back(checked_number(key, item, allowed));
  }
  if (!fits)
    fail(key, fmt::format("{}, expected a list of {} lists of {} numbers", shown(node), rows, columns));
  return values;
}

std::optional<std::vector<double>> Section::numbers_if(std::string_view key, std::size_t count,
                                                       Range allowed) const {
  if (!has(key)) return std::nullopt;
  return numbers(key, count, allowed);
}

Section Section::section(std::string_view key) const {
  const YAML::Node node = required(key);
  if (!node.IsMap()) fail(key, fmt::format("{}, expected a mapping (key: value)", shown(node)));
  Section below(node, file_, full_name(key), seen_);
  seen_->find_or_add(below, seen_->find(node_));
  return below;
}

std::optional<Section> Section::section_if(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  return section(key);
}

std::vector<Section> Section::sections(std::string_view key) const {
  const YAML::Node list = child(key);
  if (!list.IsDefined()) return {};
  if (!list.IsSequence()) fail(key, fmt::format("{}, expected a list", shown(list)));
  std::vector<Section> below;
  for (const auto& item : list) {
    const std::string name = fmt::format("{}[{}]", full_name(key), below.size());
    Section entry(item, file_, name, seen_);
    if (!item.IsMap()) entry.fail("", fmt::format("{}, expected a mapping (key: value)", shown(item)));
    seen_->find_or_add(entry, seen_->find(node_));
    below.push_back(entry);
  }
  return below;
}

fs::path Section::path(std::string_view key) const {
  const fs::path p = text(key);
  if (p.native() != one_line(p.native(), p.native().size()))
    fail(key, "holds control characters, expected a path");
  return p.is_absolute() ? p : fs::path(file_).parent_path() / p;
}

void Section::finish() const {
  const Seen::Entry* top = seen_->find(node_);
  for (const Seen::Entry& e : seen_->entries) {
    const Seen::Entry* ancestor = &e;
    while (ancestor && ancestor != top) ancestor = ancestor->parent;
    if (!ancestor) continue;
    for (const auto& entry : e.section.node_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (e.keys.contains(key)) continue;
      const std::string meant = meant_by(key, {e.keys.begin(), e.keys.end()});
      if (!meant.empty() && !stands_in(e.section.node_, meant))
        e.section.fail(key, fmt::format("is not a key here, did you mean '{}'?", meant));
      e.section.fail(key, e.keys.empty() ? "is not a key here, expected none"
                                         : fmt::format("is not a key here, expected one of: {}",
                                                       fmt::join(e.keys, ", ")));
    }
  }
}

}  // namespace headway::config
