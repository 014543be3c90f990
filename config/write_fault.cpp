#include "config/write_fault.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "config/yaml_limits.h"
#include "hal/error.h"

namespace headway::config {

void fail_to_write(const std::filesystem::path& path, const std::string& what, int number) {
  constexpr std::array kOfTheMachine{0, ENOSPC, EDQUOT, EIO, ENOMEM, EMFILE, ENFILE};
  const std::string reason = number != 0 ? fmt::format(" ({})", std::strerror(number)) : "";
  const std::string message = fmt::format("{}: {}{}", one_line(path.string(), 5000), what, reason);
  if (std::ranges::find(kOfTheMachine, number) != kOfTheMachine.end()) throw Error(message);
  const bool is_folder = number == EISDIR || number == ENOTEMPTY || number == EEXIST;
  throw InputError(message + (is_folder
                                  ? ", expected a file or nothing there"
                                  : ", expected a folder that is there and that this user may write to"));
}

}  // namespace headway::config
