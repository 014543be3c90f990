#include "config/yaml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace headway::config {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kLargestFile = 16U << 20;

std::string place(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : fmt::format("{}:{}", file, mark.line + 1);
}

std::string shown(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "nothing";
  if (node.IsMap()) return "a mapping";
  if (node.IsSequence()) return "a list";
  const std::string& s = node.Scalar();
  return fmt::format("'{}'", s.size() <= 60 ? s : s.substr(0, 57) + "...");
}

std::string allowed_text(Range r) {
  const std::string unit = r.unit.empty() ? "" : fmt::format(" {}", r.unit);
  if (std::isinf(r.lowest) && std::isinf(r.highest)) return fmt::format("a number{}", unit);
  return fmt::format("a number from {} to {}{}", r.lowest, r.highest, unit);
}

}  // namespace

// Which keys were asked for, per mapping; shared by all sections of one file.
struct Section::Seen {
  struct Entry {
    Section section;
    std::set<std::string, std::less<>> keys;
  };
  std::vector<Entry> entries;

  Entry* find(const YAML::Node& node) {
    for (Entry& e : entries)
      if (e.section.node_.is(node)) return &e;
    return nullptr;
  }
};

Section::Section(YAML::Node node, std::string file, std::string name, std::shared_ptr<Seen> seen)
    : node_(std::move(node)), file_(std::move(file)), name_(std::move(name)), seen_(std::move(seen)) {}

Section Section::load(const fs::path& file, std::string_view what) {
  std::error_code ec;
  if (!fs::is_regular_file(file, ec))
    throw InputError(fmt::format("{}: no such {} file; check the path", file.string(), what));
  if (fs::file_size(file, ec) > kLargestFile)
    throw InputError(fmt::format("{}: larger than 16 MiB, which no {} file is", file.string(), what));
  std::ifstream in(file);
  if (!in) throw InputError(fmt::format("{}: cannot be read; check its permissions", file.string()));
  std::stringstream text;
  text << in.rdbuf();
  return parse(text.str(), file.string());
}

Section Section::parse(const std::string& text, const std::string& file) {
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw InputError(fmt::format("{}: not valid YAML: {}", place(file, e.mark), e.msg));
  }
  if (!root.IsMap())
    throw InputError(fmt::format("{}: holds {}, expected a mapping (key: value)", file, shown(root)));
  auto seen = std::make_shared<Seen>();
  Section section(root, file, "", seen);
  seen->entries.push_back({section, {}});
  // The list of sections lives in `seen`; a copy held by it must not keep it alive.
  seen->entries.back().section.seen_.reset();
  return section;
}

std::string Section::full_name(std::string_view key) const {
  return name_.empty() ? std::string(key) : key.empty() ? name_ : fmt::format("{}.{}", name_, key);
}

void Section::fail(std::string_view key, const std::string& what) const {
  YAML::Mark mark = node_.Mark();
  for (const auto& entry : node_)
    if (node_.IsMap() && entry.first.IsScalar() && entry.first.Scalar() == key) mark = entry.first.Mark();
  const std::string name = full_name(key);
  throw InputError(fmt::format("{}: {}{}{}", place(file_, mark), name, name.empty() ? "" : ": ", what));
}

YAML::Node Section::child(std::string_view key) const {
  if (Seen::Entry* e = seen_->find(node_)) e->keys.emplace(key);
  YAML::Node found(YAML::NodeType::Undefined);
  int count = 0;
  for (const auto& entry : node_)
    if (entry.first.IsScalar() && entry.first.Scalar() == key) {
      found.reset(entry.second);
      ++count;
    }
  if (count > 1) fail(key, "stands here twice, expected once");
  return count == 1 ? found : YAML::Node(YAML::NodeType::Undefined);
}

YAML::Node Section::required(std::string_view key) const {
  YAML::Node node = child(key);
  if (!node.IsDefined()) fail("", fmt::format("the key '{}' is missing", key));
  return node;
}

bool Section::has(std::string_view key) const { return child(key).IsDefined(); }

double Section::checked_number(std::string_view key, const YAML::Node& node, Range allowed) const {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value) ||
      value < allowed.lowest || value > allowed.highest)
    fail(key, fmt::format("{}, expected {}", shown(node), allowed_text(allowed)));
  return value;
}

double Section::number(std::string_view key, Range allowed) const {
  return checked_number(key, required(key), allowed);
}

double Section::number_or(std::string_view key, double fallback, Range allowed) const {
  return has(key) ? number(key, allowed) : fallback;
}

int Section::integer(std::string_view key, Range allowed) const {
  const double value = number(key, allowed);
  if (value != std::floor(value) || std::abs(value) > 2e9)
    fail(key, fmt::format("{}, expected a whole number from {} to {}", value, allowed.lowest, allowed.highest));
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
  return node.Scalar();
}

std::string Section::text_or(std::string_view key, std::string_view fallback) const {
  return has(key) ? text(key) : std::string(fallback);
}

std::string Section::choice(std::string_view key, const std::vector<std::string>& allowed) const {
  std::string value = text(key);
  if (std::find(allowed.begin(), allowed.end(), value) == allowed.end())
    fail(key, fmt::format("'{}', expected one of: {}", value, fmt::join(allowed, ", ")));
  return value;
}

std::string Section::choice_or(std::string_view key, std::string_view fallback,
                               const std::vector<std::string>& allowed) const {
  return has(key) ? choice(key, allowed) : std::string(fallback);
}

std::vector<double> Section::numbers(std::string_view key, std::size_t count, Range allowed) const {
  const YAML::Node node = required(key);
  if (!node.IsSequence() || node.size() != count)
    fail(key, fmt::format("{}{}, expected a list of {} numbers", shown(node),
                          node.IsSequence() ? fmt::format(" of {}", node.size()) : "", count));
  std::vector<double> values;
  values.reserve(count);
  for (const auto& item : node) values.push_back(checked_number(key, item, allowed));
  return values;
}

std::optional<std::vector<double>> Section::numbers_if(std::string_view key, std::size_t count, Range allowed) const {
  if (!has(key)) return std::nullopt;
  return numbers(key, count, allowed);
}

Section Section::section(std::string_view key) const {
  const YAML::Node node = required(key);
  if (!node.IsMap()) fail(key, fmt::format("{}, expected a mapping (key: value)", shown(node)));
  Section below(node, file_, full_name(key), seen_);
  if (!seen_->find(node)) {
    seen_->entries.push_back({below, {}});
    seen_->entries.back().section.seen_.reset();
  }
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
    seen_->entries.push_back({entry, {}});
    seen_->entries.back().section.seen_.reset();
    below.push_back(entry);
  }
  return below;
}

fs::path Section::path(std::string_view key) const {
  const fs::path p = text(key);
  return p.is_absolute() ? p : fs::path(file_).parent_path() / p;
}

void Section::finish() const {
  for (const Seen::Entry& e : seen_->entries)
    for (const auto& entry : e.section.node_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (e.keys.contains(key)) continue;
      const std::vector<std::string> known(e.keys.begin(), e.keys.end());
      e.section.fail(key, fmt::format("is not a key here, expected one of: {}", fmt::join(known, ", ")));
    }
}

}  // namespace headway::config
