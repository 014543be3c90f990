// What the program says on stdout and stderr: nowhere else than there, and in one line where that cannot be.
#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace headway::app {

/// Where the program was started with stdin, stdout or stderr closed, opens /dev/null in its place: else the
/// next thing that is opened, such as a CAN adapter, would get what is meant for people. To be called before
/// anything else is opened. Ends the program where even that cannot be had.
void fill_standard_streams() noexcept;

/// On stderr, as fmt::print does; but where that is full or gone there is nobody else to tell, and no reason
/// to end otherwise than without it.
template <class... Values>
void say_error(fmt::format_string<Values...> text, Values&&... values) {
  const std::string said = fmt::format(text, std::forward<Values>(values)...);
  std::fwrite(said.data(), 1, said.size(), stderr);
}

/// Hands over what was said on stdout so far. Throws Error, with the reason, where that was not taken.
void flush_output();

}  // namespace headway::app
