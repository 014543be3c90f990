#include "app/output_folder.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "hal/error.h"
#include "nav/floor_files.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

/// What a report.json says of the run that wrote it.
struct Former {
  std::string command;  ///< empty where it is not said
  std::vector<std::string> names;
};

std::optional<Former> former_in(const fs::path& folder) {
  const fs::path file = folder / "report.json";
  std::error_code error;
  if (!fs::exists(fs::symlink_status(file, error))) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  const auto report = nlohmann::json::parse(in, nullptr, false);
  Former former;
  if (!report.is_object()) return former;
  if (const auto command = report.find("command"); command != report.end() && command->is_string())
    former.command = command->get<std::string>();
  if (const auto files = report.find("files"); files != report.end() && files->is_array())
    for (const auto& name : *files)
      if (name.is_string()) former.names.push_back(name.get<std::string>());
  return former;
}

/// A report may have been changed: what leads out of its folder is not touched.
bool lies_here(std::string_view name) {
  return !name.empty() && name != "." && name != ".." && name.find('/') == name.npos;
}

void remove_former(const fs::path& folder, const std::string& command);

void remove_named(const fs::path& folder, const std::string& command, const std::vector<std::string>& names) {
  std::error_code ignored;
  for (std::string name : names) {
    const bool below = name.ends_with('/');
    if (below) name.pop_back();
    if (!lies_here(name)) continue;
    const fs::file_status status = fs::symlink_status(folder / name, ignored);
    if (below && fs::is_directory(status)) remove_former(folder / name, command);
    // Of folders, only those that are empty now.
    fs::remove(folder / name, ignored);
  }
}

void remove_former(const fs::path& folder, const std::string& command) {
  const auto former = former_in(folder);
  if (!former || former->command != command) return;
  remove_named(folder, command, former->names);
  std::error_code ignored;
  fs::remove(folder / "report.json", ignored);
}

/// The folder and those above it that are not there, the innermost first.
std::vector<fs::path> missing(fs::path folder) {
  std::vector<fs::path> all;
  std::error_code ignored;
  for (; !folder.empty() && !fs::exists(folder, ignored); folder = folder.parent_path())
    all.push_back(folder);
  return all;
}

}  // namespace

OutputFolder::OutputFolder(fs::path folder, std::string command, std::initializer_list<const char*> names)
    : folder_(std::move(folder)), command_(std::move(command)), made_(missing(folder_)) {
  make_folder(folder_);
  if (const auto former = former_in(folder_); former && former->command != command_) {
    throw InputError(fmt::format("{}: is {}, expected a folder without one, or of an earlier 'headway {}'",
                                 (folder_ / "report.json").string(),
                                 former->command.empty() ? "the report of something else"
                                                         : "the report of 'headway " + former->command + "'",
                                 command_));
  }
  remove_former(folder_, command_);
  for (const char* name : names) refuse_what_is_there(name);
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : folder_(std::move(other.folder_)),
      command_(std::move(other.command_)),
      made_(std::move(other.made_)),
      kept_(std::exchange(other.kept_, true)),
      names_(std::move(other.names_)) {}

OutputFolder::~OutputFolder() {
  if (!kept_) remove_all();
}

void OutputFolder::remove_all() noexcept {
  try {
    remove_named(folder_, command_, names_);
    std::error_code ignored;
    for (const fs::path& folder : made_) fs::remove(folder, ignored);
  } catch (const std::exception&) {
    // Nothing more can be done: the fault that ends the run is told.
  }
}

void OutputFolder::refuse_what_is_there(std::string_view name) const {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(folder_ / name, ignored)))
    throw InputError(fmt::format(
        "{}: is there already, and of no earlier 'headway {}' that ended; move it, or choose another --out",
        (folder_ / name).string(), command_));
}

fs::path OutputFolder::file(std::string_view name) {
  if (std::find(names_.begin(), names_.end(), name) == names_.end()) {
    refuse_what_is_there(name);
    names_.emplace_back(name);
  }
  return folder_ / name;
}

OutputFolder OutputFolder::below(const std::string& name) {
  names_.push_back(name + "/");
  return {folder_ / name, command_};
}

void OutputFolder::report(const Json& content) {
  Json whole = {{"command", command_}};
  whole.update(content);
  whole["files"] = names_;
  write_json(folder_ / "report.json", whole);
  kept_ = true;
}

void write_floor(const nav::FloorMap& floor, OutputFolder& folder) {
  for (const char* name : {"floor.pgm", "floor.yaml"}) folder.file(name);
  nav::write_map_server(floor, folder.path());
}

std::string OutputFolder::list() const {
  return fmt::format("{}: report.json{}{}", folder_.string(), names_.empty() ? "" : ", ",
                     fmt::join(names_, ", "));
}

}  // namespace headway::app
