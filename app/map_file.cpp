#include "app/map_file.h"

#include <fmt/format.h>

#include "app/whole_map.h"
#include "hal/error.h"
#include "nav/octomap_files.h"

namespace headway::app {

namespace {

namespace fs = std::filesystem;

nav::SavedMap read_any(const fs::path& file) {
  if (file.extension() == ".hmap") return nav::read_saved_map(file);
  if (file.extension() == ".bt") return nav::read_bt(file);
  if (file.extension() == ".ot") return nav::read_ot(file);
  throw InputError(
      fmt::format("{}: has an unknown ending, expected a map (.hmap, .bt or .ot)", file.string()));
}

}  // namespace

nav::SavedMap read_saved(const fs::path& file) {
  nav::SavedMap saved = read_any(file);
  if (saved.map.size() == 0)
    throw InputError(fmt::format("{}: knows nothing, expected a map", file.string()));
  return saved;
}

nav::ColdMap read_known(const fs::path& file) { return read_saved(file).map; }

nav::VoxelMap voxels_of(const nav::ColdMap& known, const nav::VoxelMapConfig& like, const fs::path& file) {
  try {
    return whole_map(known, like);
  } catch (const InputError& fault) {
    throw InputError(fmt::format("{}: {}", file.string(), fault.what()));
  }
}

nav::VoxelMap read_map(const fs::path& file, const nav::VoxelMapConfig& like) {
  return voxels_of(read_known(file), like, file);
}

}  // namespace headway::app
