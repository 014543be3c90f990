#include "runtime/recording/byte_sink.h"

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "config/write_fault.h"

namespace headway::recording {

FileSink::FileSink(std::filesystem::path file)
    : path_(std::move(file)),
      descriptor_(open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) config::fail_to_write(path_, "cannot be made", errno);
}

FileSink::~FileSink() { close(descriptor_); }

void FileSink::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) config::fail_to_write(path_, "cannot be written", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(done));
  }
}

void FileSink::sync() {
  if (fdatasync(descriptor_) != 0) config::fail_to_write(path_, "cannot be brought to the disk", errno);
}

void FileSink::cut(std::uint64_t size) {
  const auto end = static_cast<off_t>(size);
  if (ftruncate(descriptor_, end) != 0 || lseek(descriptor_, end, SEEK_SET) != end)
    config::fail_to_write(path_, "cannot be cut", errno);
}

}  // namespace headway::recording
