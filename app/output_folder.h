// The folder into which a command writes. What an earlier run of the same command left there does not
// mislead: it is removed before anything is written. Nothing else is.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/report.h"
#include "nav/floor_map.h"

namespace headway::app {

/// For every --out.
inline constexpr const char* kOutHelp =
    "Folder for what is written; made if need be. Files of this command's earlier run are removed first";

/// report.json, which ends every run, holds the command's name under "command" and its files' under "files".
/// Those, and only those, are removed when the same command comes again; a folder with another report.json is
/// refused.
class OutputFolder {
 public:
  /// Makes the folder. Throws InputError where its name cannot be one's or its report.json is not of this
  /// command, Error where it cannot be written to.
  OutputFolder(std::filesystem::path folder, std::string command);

  /// A file that is about to be written.
  std::filesystem::path file(std::string_view name);
  /// A folder for a part of the same run, with a report of its own.
  OutputFolder below(const std::string& name);
  /// Writes report.json, as the last file. Throws as write_json does.
  void report(const Json& content);

  const std::filesystem::path& path() const { return folder_; }
  /// "FOLDER: report.json, a.png, ..."
  std::string list() const;

 private:
  std::filesystem::path folder_;
  std::string command_;
  std::vector<std::string> names_;  ///< in the order of writing; folders end with a slash
};

/// floor.pgm and floor.yaml. Throws as nav::write_whole does.
void write_floor(const nav::FloorMap& floor, OutputFolder& folder);

}  // namespace headway::app
