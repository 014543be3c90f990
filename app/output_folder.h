// The folder into which a command writes. What an earlier run of the same command left there does not
// mislead: it is removed before anything is written. Nothing else is, nor written over.
#pragma once

#include <filesystem>
#include <initializer_list>
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
/// refused. A run that ends without its report leaves nothing behind.
class OutputFolder {
 public:
  /// Makes the folder. `names`: files that a long run will write at its end. Throws InputError where its
  /// report.json is not of this command or such a file is somebody else's, and as make_folder does.
  OutputFolder(std::filesystem::path folder, std::string command,
               std::initializer_list<const char*> names = {});
  OutputFolder(OutputFolder&& other) noexcept;
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

  /// A file that is about to be written. Throws InputError where there is one that this run did not write.
  std::filesystem::path file(std::string_view name);
  /// A folder for a part of the same run, with a report of its own.
  OutputFolder below(const std::string& name);
  /// Writes report.json, as the last file. Throws as write_json does.
  void report(const Json& content);
  /// What was written so far stays, report or not: it shows why the run ends.
  void keep() { kept_ = true; }

  const std::filesystem::path& path() const { return folder_; }
  /// "FOLDER: report.json, a.png, ..."
  std::string list() const;

 private:
  void refuse_what_is_there(std::string_view name) const;
  void remove_all() noexcept;

  std::filesystem::path folder_;
  std::string command_;
  std::vector<std::filesystem::path> made_;  ///< folders that were not there before, the innermost first
  bool kept_ = false;
  std::vector<std::string> names_;  ///< in the order of writing; folders end with a slash
};

/// floor.pgm and floor.yaml. Throws as nav::write_whole does.
void write_floor(const nav::FloorMap& floor, OutputFolder& folder);

}  // namespace headway::app
