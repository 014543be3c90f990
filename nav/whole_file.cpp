#include "nav/whole_file.h"

#include <system_error>

#include "hal/error.h"

namespace headway::nav {

void write_whole(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write) {
  std::filesystem::path part = file;
  part += ".part";
  std::error_code error;
  {
    std::ofstream out(part, std::ios::binary | std::ios::trunc);
    if (!out) throw InputError(file.string() + ": cannot be written; is the folder there and writable?");
    write(out);
    out.close();
    if (!out) {
      std::filesystem::remove(part, error);
      throw InputError(file.string() + ": cannot be written completely; is the disk full?");
    }
  }
  std::filesystem::rename(part, file, error);
  if (error) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    throw InputError(file.string() + ": cannot be replaced: " + error.message());
  }
}

std::ifstream open_whole(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(file.string() + ": no such file");
  std::ifstream in(file, std::ios::binary);
  if (!std::filesystem::is_regular_file(file, error) || !in) {
    throw InputError(file.string() + ": cannot be read; expected a file that this user may read");
  }
  return in;
}

}  // namespace headway::nav
