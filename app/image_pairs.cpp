#include "app/image_pairs.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <system_error>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostImages = 10'000;

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool is_image(const fs::path& file) {
  static constexpr std::array kEndings{".png",  ".jpg", ".jpeg", ".bmp", ".tif",
                                       ".tiff", ".pgm", ".ppm",  ".webp"};
  const std::string ending = lower(file.extension().string());
  return std::any_of(kEndings.begin(), kEndings.end(), [&](const char* e) { return ending == e; });
}

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

/// * stands for any run of characters, ? for any one.
bool matches(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern[0] == '*')
    return matches(pattern.substr(1), name) || (!name.empty() && matches(pattern, name.substr(1)));
  return !name.empty() && (pattern[0] == '?' || pattern[0] == name[0]) &&
         matches(pattern.substr(1), name.substr(1));
}

std::vector<fs::path> matching(const fs::path& pattern) {
  const fs::path folder = pattern.has_parent_path() ? pattern.parent_path() : fs::path(".");
  if (!is_folder(folder))
    throw InputError(fmt::format("{}: no such folder, expected images", folder.string()));
  std::vector<fs::path> found = images_in(folder);
  std::erase_if(
      found, [&](const fs::path& p) { return !matches(pattern.filename().string(), p.filename().string()); });
  if (found.empty())
    throw InputError(fmt::format("{}: no image has such a name; check the path", pattern.string()));
  return found;
}

std::vector<fs::path> starting_with(const std::string& side, const std::vector<fs::path>& files) {
  std::vector<fs::path> found;
  for (const fs::path& file : files)
    if (lower(file.filename().string()).starts_with(side)) found.push_back(file);
  return found;
}

struct Sides {
  std::string place;  ///< for messages
  std::vector<fs::path> left, right;
};

Sides in_folder(const fs::path& folder) {
  for (const auto& [left, right] :
       {std::pair{"left", "right"}, {"cam0/data", "cam1/data"}, {"cam0", "cam1"}}) {
    if (is_folder(folder / left) && is_folder(folder / right))
      return {folder.string(), images_in(folder / left), images_in(folder / right)};
  }
  const std::vector<fs::path> files = images_in(folder);
  return {folder.string(), starting_with("left", files), starting_with("right", files)};
}

Sides sides_of(const std::vector<std::string>& paths) {
  const auto is_pattern = [](const std::string& p) { return p.find_first_of("*?") != std::string::npos; };
  if (paths.size() == 1 && is_folder(paths[0])) return in_folder(paths[0]);
  if (paths.size() == 2 && is_folder(paths[0]) && is_folder(paths[1]))
    return {paths[0] + ", " + paths[1], images_in(paths[0]), images_in(paths[1])};
  if (paths.size() == 2 && is_pattern(paths[0]) && is_pattern(paths[1]))
    return {paths[0] + ", " + paths[1], matching(paths[0]), matching(paths[1])};
  std::vector<fs::path> files;
  for (const std::string& path : paths) {
    if (is_folder(path) || is_pattern(path) || !is_image(path)) {
      throw InputError(fmt::format(
          "{}: expected one folder, two folders, two patterns in quotes, or images left... and right...",
          path));
    }
    files.emplace_back(path);
  }
  std::sort(files.begin(), files.end());
  return {paths.front() + " ...", starting_with("left", files), starting_with("right", files)};
}

/// What the names of a pair have in common.
std::string name_of(const fs::path& file) {
  std::string stem = file.stem().string();
  for (const std::string side : {"left", "right"}) {
    if (const std::size_t at = lower(stem).find(side); at != std::string::npos)
      return stem.erase(at, side.size());
  }
  return stem;
}

}  // namespace

std::vector<fs::path> images_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (is_image(entry.path())) files.push_back(entry.path());
  }
  if (error) throw InputError(fmt::format("{}: cannot be listed ({})", folder.string(), error.message()));
  if (files.size() > kMostImages) {
    throw InputError(
        fmt::format("{}: has {} images, expected at most {}", folder.string(), files.size(), kMostImages));
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<ImagePair> find_image_pairs(const std::vector<std::string>& paths) {
  if (paths.empty()) throw InputError("no images, expected a folder with left* and right* images");
  const Sides sides = sides_of(paths);
  if (sides.left.empty() && sides.right.empty())
    throw InputError(fmt::format("{}: holds no images left... and right...", sides.place));
  std::map<std::string, ImagePair> pairs;
  for (const fs::path& file : sides.left) pairs[name_of(file)].left = file;
  for (const fs::path& file : sides.right) pairs[name_of(file)].right = file;
  std::vector<ImagePair> out;
  for (auto& [name, pair] : pairs) {
    // Of left.png and right.png nothing is common.
    pair.name = name.empty() ? pair.left.stem().string() + " and " + pair.right.stem().string() : name;
    if (pair.left.empty() || pair.right.empty()) {
      throw InputError(fmt::format("{}: has no partner for the {} camera ({} left and {} right images)",
                                   (pair.left.empty() ? pair.right : pair.left).string(),
                                   pair.left.empty() ? "left" : "right", sides.left.size(),
                                   sides.right.size()));
    }
    out.push_back(std::move(pair));
  }
  return out;
}

}  // namespace headway::app
