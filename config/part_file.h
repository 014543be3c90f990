// A file under way: FILE.part, which takes FILE's place when all of it is there. A link stays: what it leads
// to is replaced.
#pragma once

#include <filesystem>
#include <system_error>

namespace headway::config {

/// Gone on the way out unless it has taken its place.
class PartFile {
 public:
  explicit PartFile(const std::filesystem::path& file) : file_(behind_links(file)), part_(file_) {
    part_ += ".part";
  }
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
  static std::filesystem::path behind_links(std::filesystem::path file) {
    std::error_code none;
    for (int most = 40; most > 0 && std::filesystem::is_symlink(file, none); --most)
      file = file.parent_path() / std::filesystem::read_symlink(file, none);
    return file;
  }

  std::filesystem::path file_, part_;
  bool placed_ = false;
};

}  // namespace headway::config
