#include "app/state_folder.h"

#include <cstdlib>
#include <string>

namespace headway::app {

namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace

std::filesystem::path state_folder() {
  namespace fs = std::filesystem;
  // systemd separates several by colons; ours has one.
  if (const std::string state = variable("STATE_DIRECTORY"); !state.empty())
    return state.substr(0, state.find(':'));
  if (const std::string state = variable("XDG_STATE_HOME"); !state.empty())
    return fs::path(state) / "headway";
  if (const std::string home = variable("HOME"); !home.empty())
    return fs::path(home) / ".local/state/headway";
  return fs::temp_directory_path() / "headway";
}

}  // namespace headway::app
