// Where the program keeps what outlives it.
#pragma once

#include <filesystem>

namespace headway::app {

/// $STATE_DIRECTORY (which systemd sets for a service), else headway/ in the user's state folder
/// ($XDG_STATE_HOME or ~/.local/state), else in the machine's temporary one.
std::filesystem::path state_folder();

}  // namespace headway::app
