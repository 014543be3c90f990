// Where a recording is read from: a file, or bytes in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace headway::recording {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  /// Fills `into` from the byte `at` on. False where the source does not hold as many, or cannot be read.
  virtual bool read(std::uint64_t at, std::span<std::byte> into) const = 0;
};

/// A file as it is when it is opened; one that grows meanwhile is read up to there. Throws InputError where
/// it cannot be opened.
class FileSource final : public ByteSource {
 public:
  explicit FileSource(const std::filesystem::path& file);
  ~FileSource() override;
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::uint64_t size() const override { return size_; }
  bool read(std::uint64_t at, std::span<std::byte> into) const override;

 private:
  int descriptor_;
  std::uint64_t size_ = 0;
};

/// Bytes that somebody else keeps.
class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::uint64_t size() const override { return bytes_.size(); }
  bool read(std::uint64_t at, std::span<std::byte> into) const override;

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace headway::recording
