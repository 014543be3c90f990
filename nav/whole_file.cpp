#include "nav/whole_file.h"

#include <cerrno>
#include <cstdio>
#include <sstream>
#include <system_error>

#include "config/part_file.h"
#include "config/write_fault.h"
#include "hal/error.h"

namespace headway::nav {

namespace fs = std::filesystem;

namespace {

/// The stream of this program that goes to this regular file, if any: a file opened anew would be written
/// from its start again.
std::FILE* own_stream_to(const fs::path& file) {
  std::error_code none;
  if (!fs::is_regular_file(file, none)) return nullptr;
  if (fs::equivalent(file, "/proc/self/fd/1", none)) return stdout;
  return fs::equivalent(file, "/proc/self/fd/2", none) ? stderr : nullptr;
}

void write_to_stream(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  std::fflush(stdout);  // which may go there as well, and came before
  errno = 0;
  if (std::FILE* stream = own_stream_to(file)) {
    std::ostringstream text;
    write(text);
    std::fwrite(text.view().data(), 1, text.view().size(), stream);
    if (std::fflush(stream) != 0 || std::ferror(stream) != 0)
      config::fail_to_write(file, "cannot be written completely", errno);
    return;
  }
  std::ofstream out(file, std::ios::binary);
  if (!out) config::fail_to_write(file, "cannot be written", errno);
  write(out);
  out.close();
  if (!out) config::fail_to_write(file, "cannot be written completely", errno);
}

}  // namespace

bool is_stream(const fs::path& file) {
  std::error_code none;
  const fs::file_status there = fs::status(file, none);
  return fs::exists(there) && !fs::is_directory(there) &&
         (!fs::is_regular_file(there) || own_stream_to(file) != nullptr);
}

void write_whole(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  std::error_code ignored, circle;
  if (!fs::exists(file, circle) && circle == std::errc::too_many_symbolic_link_levels)
    config::fail_to_write(file, "cannot be written", ELOOP);
  if (file.has_parent_path() && !fs::is_directory(file.parent_path(), ignored))
    config::fail_to_write(file, "cannot be written", ENOENT);
  if (fs::is_directory(file, ignored))
    throw InputError(file.string() + ": is a folder, expected a file or nothing there");
  if (is_stream(file)) return write_to_stream(file, write);
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
