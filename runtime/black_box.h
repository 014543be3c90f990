// The last half minute, always in memory that was taken at the beginning; after a fault it becomes a file.
// Pictures are thinned to what their share of the memory holds of so long a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "runtime/preface.h"

namespace headway::runtime {

/// Rows in one piece of memory: a new one takes the place of the oldest. Nothing is allocated once it is
/// made.
class RowRing {
 public:
  RowRing(std::size_t bytes, std::size_t most_rows) : bytes_(bytes), entries_(most_rows) {}

  /// False, and nothing changes, for a row that is longer than all of it.
  bool put(const Row& row);
  std::size_t size() const { return count_; }
  /// From the oldest (0) to the newest.
  Row at(std::size_t i) const;

 private:
  struct Entry {
    Row row;  ///< its bytes lie in `bytes_`
    std::size_t begin = 0;
  };
  const Entry& oldest() const { return entries_[first_]; }
  void forget_oldest();

  std::vector<std::byte> bytes_;
  std::vector<Entry> entries_;
  std::size_t first_ = 0, count_ = 0, end_ = 0;
};

struct BlackBoxConfig {
  std::filesystem::path folder;  ///< made when there is something to write
  Duration span = seconds(30);
  std::size_t bytes = std::size_t{16} << 20;  ///< of all but pictures
  std::size_t picture_bytes = std::size_t{48} << 20;
  Duration apart =
      seconds(30);  ///< files are written no more often; a fault meanwhile is in the next one's time
};

/// One thread.
class BlackBox {
 public:
  BlackBox(BlackBoxConfig config, Preface preface);

  /// Allocates nothing.
  void put(const Row& row);
  /// Writes what is at hand, up to `now`; nothing where the last time was less than `apart` ago. Throws as
  /// FileSink does.
  std::optional<std::filesystem::path> write(const std::string& fault, Time now);

 private:
  bool keep_picture(const Row& row);

  BlackBoxConfig config_;
  Preface preface_;
  RowRing rows_, pictures_;
  // Of the pictures kept last, which are of one time:
  std::optional<Time> picture_time_;
  std::size_t picture_size_ = 0;
  std::optional<Time> written_;
};

}  // namespace headway::runtime
