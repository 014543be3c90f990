#include "app/file_kind.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "hal/error.h"
#include "vision/calibration_file.h"

namespace headway::app {

namespace {

struct Kind {
  std::string_view name;
  std::vector<std::string_view> keys;  ///< that no other kind has
};

/// In FileKind's order; then those that no command but the rigs' reads.
const std::array<Kind, 7>& kinds() {
  static const std::array<Kind, 7> all{
      {{"a robot file", {"neck", "gait", "planner", "mission", "body"}},
       {"a world", {"floor", "room", "goal", "start", "textures"}},
       {"a floor map (map_server's)", {"image", "occupied_thresh", "free_thresh"}},
       {"a rig", {"right_from_left", "left", "right"}},
       {"a head with several rigs", {"rigs"}},
       {"Kalibr's camchain", {"cam0", "cam1"}},
       {"a calibration", {"projection_matrix", "T_BS", "M1", "M2", "K1", "K2", "cameraMatrix1"}}}};
  return all;
}

}  // namespace

void require_kind(const std::filesystem::path& file, FileKind expected) {
  const auto has_key_of = [](const config::Section& section, const Kind& kind) {
    return std::ranges::any_of(kind.keys, [&](std::string_view key) { return section.has(key); });
  };
  const Kind& wanted = kinds()[static_cast<std::size_t>(expected)];
  const Kind* found = nullptr;
  try {
    const config::Section section = vision::load_calibration(file);
    if (has_key_of(section, wanted)) return;
    for (const Kind& kind : kinds())
      if (!found && has_key_of(section, kind)) found = &kind;
  } catch (const InputError&) {
    return;
  }
  if (found)
    throw InputError(fmt::format("{}: looks like {}, expected {}", file.string(), found->name, wanted.name));
}

}  // namespace headway::app
