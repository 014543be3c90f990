// Where a recording's bytes go: a file, or whatever a test makes of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace headway::recording {

class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Appends all of it, or throws.
  virtual void write(std::span<const std::byte> bytes) = 0;
  /// Returns when what was written outlives the machine's death, or throws.
  virtual void sync() = 0;
  /// Forgets what was written from `size` on. Throws where it cannot.
  virtual void cut(std::uint64_t size) = 0;
};

/// A new file. Throws Error where the machine does not let it be written (a full or broken disk), InputError
/// where the path is wrong; one that is there already is not written over.
class FileSink final : public ByteSink {
 public:
  explicit FileSink(std::filesystem::path file);
  ~FileSink() override;
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  void write(std::span<const std::byte> bytes) override;
  void sync() override;
  void cut(std::uint64_t size) override;

 private:
  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace headway::recording
