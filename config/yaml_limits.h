// What a YAML text must keep to before it is read: one document, not deep, not huge. A parser's own limits
// are wider than its stack and the machine's memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace headway::config {

struct YamlLimits {
  std::uintmax_t bytes = 1U << 20;
  std::size_t depth = 32;       ///< mappings and lists inside each other
  std::size_t values = 100000;  ///< scalars, mappings, lists and aliases together
};

/// Throws InputError (`file:line: what, expected what`) where `text` breaks a limit, is no text (an image,
/// say) or no YAML, or holds a second document. An empty text passes.
void check_yaml(const std::string& text, const std::string& file, const YamlLimits& limits = {});

bool is_utf8(std::string_view text);

/// `text` on one line, in UTF-8: a control character becomes a space, a byte that is no character a question
/// mark, and what is longer than `longest` bytes is cut.
std::string one_line(const std::string& text, std::size_t longest = 300);

}  // namespace headway::config
