#include "config/spelling.h"

#include <algorithm>
#include <cctype>
#include <iterator>

namespace headway::config {

std::size_t letters_apart(std::string_view one, std::string_view other) {
  using Row = std::vector<std::size_t>;
  Row before(other.size() + 1), row(other.size() + 1), next(other.size() + 1);
  for (std::size_t j = 0; j <= other.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= one.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= other.size(); ++j) {
      const std::size_t changed = row[j - 1] + (one[i - 1] == other[j - 1] ? 0 : 1);
      next[j] = std::min({changed, row[j] + 1, next[j - 1] + 1});
      if (i > 1 && j > 1 && one[i - 1] == other[j - 2] && one[i - 2] == other[j - 1])
        next[j] = std::min(next[j], before[j - 2] + 1);
    }
    before.swap(row);
    row.swap(next);
  }
  return row.back();
}

namespace {

std::string without_digits(std::string_view word) {
  std::string rest;
  std::copy_if(word.begin(), word.end(), std::back_inserter(rest), [](char c) { return c < '0' || c > '9'; });
  return rest;
}

/// In small letters, and an angle in degrees: what differs in those only says the same.
std::string sense_of(std::string word) {
  std::ranges::transform(word, word.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::size_t unit = word.find("_rad");
  const std::size_t end = unit == word.npos ? unit : unit + 4;
  if (end != word.npos && (end == word.size() || word[end] == '_')) word.replace(unit, 4, "_deg");
  return word;
}

/// `longer` is `word` and something more, such as a unit.
bool continues(std::string_view longer, std::string_view word) {
  constexpr std::size_t kShortest = 3;
  return word.size() >= kShortest && longer.size() > word.size() && longer.starts_with(word) &&
         (longer[word.size()] == '_' || longer[word.size()] == '-');
}

}  // namespace

std::string meant_by(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t kLongest = 60;  // no key is as long, and a hostile text should cost nothing
  if (word.size() > kLongest) return {};
  const std::string sense = sense_of(std::string(word));
  for (const std::string& candidate : known)
    if (candidate != word && sense_of(candidate) == sense) return candidate;
  std::size_t allowed = std::min<std::size_t>(2, word.size() / 3) + 1;
  std::string nearest;
  for (const std::string& candidate : known) {
    const std::size_t apart = letters_apart(word, candidate);
    if (apart < allowed && without_digits(word) != without_digits(candidate))
      allowed = apart, nearest = candidate;
  }
  if (!nearest.empty()) return nearest;
  const auto goes_on = std::find_if(known.begin(), known.end(), [&](const std::string& candidate) {
    return continues(candidate, word) || continues(word, candidate);
  });
  return goes_on == known.end() ? std::string() : *goes_on;
}

}  // namespace headway::config
