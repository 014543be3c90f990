// A file under way: FILE.part, which takes FILE's place when all of it is there. A link stays: what it leads
// to is replaced.
#pragma once

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "config/write_fault.h"

namespace headway::config {

/// Gone on the way out unless it has taken its place.
class PartFile {
 public:
  /// Throws as fail_to_write() where links lead in a circle, or to what is no file: a device, a pipe.
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
  /// In which it takes its place.
  std::filesystem::path folder() const { return file_.has_parent_path() ? file_.parent_path() : "."; }
  /// Returns why it could not.
  std::error_code take_its_place() {
    std::error_code error;
    std::filesystem::rename(part_, file_, error);
    placed_ = !error;
    return error;
  }

 private:
  static std::filesystem::path behind_links(const std::filesystem::path& given) {
    namespace fs = std::filesystem;
    std::error_code none;
    fs::path file = given;
    for (int most = 40; most > 0 && fs::is_symlink(file, none); --most)
      file = file.parent_path() / fs::read_symlink(file, none);
    if (fs::is_symlink(file, none)) fail_to_write(given, "cannot be written", ELOOP);
    if (fs::is_other(file, none)) fail_to_write(given, "is no file that can be replaced", 0);
    return file;
  }

  std::filesystem::path file_, part_;
  bool placed_ = false;
};

}  // namespace headway::config
