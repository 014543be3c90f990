#include "runtime/durable_file.h"

#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "config/part_file.h"
#include "config/write_fault.h"

namespace headway::runtime {
namespace {

namespace fs = std::filesystem;

/// Closed on the way out.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags) : number_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  bool is_open() const { return number_ >= 0; }
  bool sync() const { return fsync(number_) == 0; }

 private:
  int number_;
};

}  // namespace

void write_durably(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  config::PartFile part(file);
  // Open all the while, so that it learns of every fault in writing back.
  const Descriptor on_disk(part.path(), O_WRONLY | O_CREAT | O_TRUNC);
  if (!on_disk.is_open()) config::fail_to_write(file, "cannot be written", errno);
  std::ofstream out(part.path(), std::ios::binary);
  write(out);
  out.close();
  if (!out || !on_disk.sync()) config::fail_to_write(file, "cannot be written completely", errno);
  if (const std::error_code error = part.take_its_place())
    config::fail_to_write(file, "cannot be replaced", error.value());
  // The name is on the disk only when the folder is.
  const Descriptor folder(part.folder(), O_RDONLY | O_DIRECTORY);
  if (!folder.is_open() || !folder.sync())
    config::fail_to_write(file, "its folder cannot be written to the disk", errno);
}

}  // namespace headway::runtime
