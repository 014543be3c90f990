// Frames that candump of can-utils has written to a file (candump -l, or -L).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>

#include "hal/can_bus.h"

namespace headway::app {

struct LoggedFrame {
  enum class Kind : std::uint8_t { kData, kExtended, kRemote, kError };

  Kind kind = Kind::kData;  ///< only kData is a data frame with an 11-bit identifier
  std::string bus;          ///< the interface it was heard on
  Duration stamp{};         ///< on the clock that candump used: since 1970, mostly
  hal::CanFrame frame;      ///< without a stamp; of other kinds `id` may have 29 bits
};

/// Reads `(1436509052.249713) can0 044#2A366C2BBA` line by line; empty lines are passed over.
class CandumpLog {
 public:
  static constexpr std::uint32_t kErrorFlag = 0x20000000;  ///< in the identifier of an error frame

  /// `on_bad_line` is told `file:line: what, expected what` of lines that are no frame, and passed over.
  /// Throws InputError where the file cannot be read.
  CandumpLog(const std::filesystem::path& file, std::function<void(const std::string&)> on_bad_line);
  /// The next frame; nothing at the end.
  std::optional<LoggedFrame> next();

 private:
  std::filesystem::path file_;
  std::ifstream in_;
  std::function<void(const std::string&)> on_bad_line_;
  std::size_t line_ = 0;
};

}  // namespace headway::app
