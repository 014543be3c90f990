#include "app/recording_folder.h"

#include <cerrno>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "app/state_folder.h"
#include "config/write_fault.h"
#include "hal/error.h"

namespace headway::app {

namespace fs = std::filesystem;

fs::path recording_folder(const fs::path& named) {
  return named.empty() ? state_folder() / "recordings" : named;
}

void require_room_to_record(const fs::path& folder, std::uint64_t room) {
  std::error_code fault;
  fs::create_directories(folder, fault);
  if (fault) config::fail_to_write(folder, "cannot be made", fault.value());
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    config::fail_to_write(folder, "cannot be written to", errno);
  const fs::space_info space = fs::space(folder, fault);
  if (!fault && space.available < room)
    throw Error(
        fmt::format("{}: {} MiB are left there, and a recording is begun with {} MiB at least; make room",
                    folder.string(), space.available >> 20, room >> 20));
}

}  // namespace headway::app
