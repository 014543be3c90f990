// A file under way: FILE.part, which takes FILE's place when all of it is there.
#pragma once

#include <filesystem>
#include <system_error>

namespace headway::config {

/// Gone on the way out unless it has taken its place.
class PartFile {
 public:
  explicit PartFile(const std::filesystem::path& file) : file_(file), part_(file) { part_ += ".part"; }
  ~PartFile() {
    std::error_code ignored;
    if (!placed_) std::filesystem::remove(part_, ignored);
  }
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  const std::filesystem::path& path() const { return part_; }
  /// Returns why it could not.
  std::error_code take_its_place() {
    std::error_code error;
    std::filesystem::rename(part_, file_, error);
    placed_ = !error;
    return error;
  }

 private:
  std::filesystem::path file_, part_;
  bool placed_ = false;
};

}  // namespace headway::config
