#include "app/report.h"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <ostream>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "app/standard_streams.h"
#include "config/write_fault.h"
#include "hal/error.h"
#include "nav/whole_file.h"

namespace headway::app {

void make_folder(const std::filesystem::path& folder) {
  if (folder.empty()) throw InputError("--out: is empty, expected a folder to write into");
  std::error_code error, unknown;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, unknown))
    config::fail_to_write(folder, "cannot be made the folder that --out names",
                          error ? error.value() : ENOTDIR);
  // Asking for permissions would be wrong for root and on read-only disks; only trying tells.
  const std::filesystem::path probe = folder / ".writable";
  errno = 0;
  const bool writable = std::ofstream(probe).good();
  const int number = errno;
  std::filesystem::remove(probe, error);
  if (!writable) config::fail_to_write(folder, "cannot be written to", number);
}

void write_json(const std::filesystem::path& file, const Json& json) {
  nav::write_whole(file, [&](std::ostream& out) { out << json.dump(2) << '\n'; });
}

Json rounded(double value, int decimals) {
  if (!std::isfinite(value)) return nullptr;
  const double unit = std::pow(10.0, decimals);
  const double scaled = std::round(value * unit);
  return scaled == 0 ? 0.0 : scaled / unit;  // no negative zero
}

Progress::Progress(std::string what) : what_(std::move(what)), terminal_(isatty(fileno(stderr)) == 1) {}

Progress::~Progress() {
  if (terminal_) say_error("\r\033[K");
}

void Progress::show(std::size_t done, std::size_t total, std::string_view note) {
  if (!terminal_) return;
  say_error("\r\033[K{}: {}/{} {}", what_, done, total, note);
  std::fflush(stderr);
}

}  // namespace headway::app
