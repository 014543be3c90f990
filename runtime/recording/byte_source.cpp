#include "runtime/recording/byte_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::recording {

FileSource::FileSource(const std::filesystem::path& file)
    : descriptor_(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  struct stat kind {};
  if (descriptor_ < 0 || fstat(descriptor_, &kind) != 0) {
    const std::string why = std::strerror(errno);
    if (descriptor_ >= 0) close(descriptor_);
    throw InputError(file.string() + ": cannot be opened (" + why + "), expected a recording (.mcap)");
  }
  if (!S_ISREG(kind.st_mode)) {
    close(descriptor_);
    throw InputError(file.string() + ": is no file, expected a recording (.mcap)");
  }
  size_ = static_cast<std::uint64_t>(kind.st_size);
}

FileSource::~FileSource() { close(descriptor_); }

bool FileSource::read(std::uint64_t at, std::span<std::byte> into) const {
  if (at > size_ || into.size() > size_ - at) return false;
  while (!into.empty()) {
    const ssize_t done = pread(descriptor_, into.data(), into.size(), static_cast<off_t>(at));
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    at += static_cast<std::uint64_t>(done);
    into = into.subspan(static_cast<std::size_t>(done));
  }
  return true;
}

bool MemorySource::read(std::uint64_t at, std::span<std::byte> into) const {
  if (at > bytes_.size() || into.size() > bytes_.size() - at) return false;
  std::ranges::copy(bytes_.subspan(static_cast<std::size_t>(at), into.size()), into.begin());
  return true;
}

}  // namespace headway::recording
