#include "nav/whole_file.h"

#include <cerrno>
#include <system_error>

#include "config/part_file.h"
#include "config/write_fault.h"
#include "hal/error.h"

namespace headway::nav {

namespace fs = std::filesystem;

void write_whole(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  std::error_code ignored;
  if (file.has_parent_path() && !fs::is_directory(file.parent_path(), ignored))
    config::fail_to_write(file, "cannot be written", ENOENT);
  if (fs::is_directory(file, ignored))
    throw InputError(file.string() + ": is a folder, expected a file or nothing there");
  config::PartFile part(file);
  errno = 0;
  std::ofstream out(part.path(), std::ios::binary | std::ios::trunc);
  if (!out) config::fail_to_write(file, "cannot be written", errno);
  write(out);
  out.close();
  if (!out) config::fail_to_write(file, "cannot be written completely", errno);
  if (const std::error_code error = part.take_its_place())
    config::fail_to_write(file, "cannot be replaced", error.value());
}

std::ifstream open_whole(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(file.string() + ": no such file");
  if (std::filesystem::is_directory(file, error))
    throw InputError(file.string() + ": is a folder, expected a file");
  std::ifstream in(file, std::ios::binary);
  if (!std::filesystem::is_regular_file(file, error) || !in) {
    throw InputError(file.string() + ": cannot be read; expected a file that this user may read");
  }
  return in;
}

}  // namespace headway::nav
