// A recording in files of bounded size: NAME_00.mcap, NAME_01.mcap, ... Each is whole once it is ended, and
// readable up to its last whole chunk before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "runtime/preface.h"
#include "runtime/recording/byte_sink.h"

namespace headway::runtime {

struct FileTapeConfig {
  std::filesystem::path folder;                   ///< made if need be
  std::string name = "recording";                 ///< of its files; a number is added that no file there has
  std::uint64_t rotate = std::uint64_t{1} << 30;  ///< a file that has become larger is ended [bytes]
  Duration sync_every = seconds(1);
  /// How a file is made; another in tests.
  std::function<std::unique_ptr<recording::ByteSink>(const std::filesystem::path&)> make =
      [](const std::filesystem::path& file) { return std::make_unique<recording::FileSink>(file); };
};

/// One thread. What it cannot write it throws, once: then the file is ended as well as the disk lets it be,
/// and what is put later is left out.
class FileTape {
 public:
  /// Makes the first file. `begin`: the time at which the recording begins. Throws as FileSink does.
  FileTape(FileTapeConfig config, Preface preface, Time begin);

  /// True when it began another file with it.
  bool put(const Row& row);
  /// Call now and then, by a clock that goes on: brings what was written to the disk.
  void tend(Time now);
  /// Ends the file. Nothing was put: then there is none.
  void finish();

  bool broken() const { return broken_; }
  /// The file that is being written, or was last.
  const std::filesystem::path& file() const { return file_; }
  std::uint64_t bytes() const { return bytes_before_ + (writer_ ? writer_->size() : 0); }

 private:
  void begin(Time t);
  template <class Work>
  void guarded(Work&& work);

  FileTapeConfig config_;
  Preface preface_;
  std::string stem_;
  int part_ = 0;
  std::filesystem::path file_;
  std::unique_ptr<recording::ByteSink> sink_;
  std::unique_ptr<recording::McapWriter> writer_;
  std::uint64_t bytes_before_ = 0;  ///< in the files before this one
  Time last_sync_{};
  std::uint64_t synced_size_ = 0;
  bool empty_ = true, broken_ = false;
};

}  // namespace headway::runtime
