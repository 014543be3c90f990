// What commands leave behind besides pictures: folders, JSON files, progress on a terminal, stage times.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace headway::app {

/// Keys keep the order in which they were set, so that equal runs write equal bytes and a person can read
/// them.
using Json = nlohmann::ordered_json;

/// Creates the folder (and those above it) if need be. Throws as config::fail_to_write where it cannot be
/// made or written to.
void make_folder(const std::filesystem::path& folder);

/// Indented, with a newline at the end. Throws as nav::write_whole does.
void write_json(const std::filesystem::path& file, const Json& json);

/// To so many decimals, so that reports stay readable. Not finite becomes null.
Json rounded(double value, int decimals = 4);

/// One line that is rewritten on stderr; silent unless stderr is a terminal.
class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();  ///< clears the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// "what: done/total note"
  void show(std::size_t done, std::size_t total, std::string_view note = "");

 private:
  std::string what_;
  bool terminal_;
};

/// Milliseconds since it was made or last asked.
class Stopwatch {
 public:
  double lap_ms() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace headway::app
