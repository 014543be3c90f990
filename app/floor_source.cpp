#include "app/floor_source.h"

#include <fmt/format.h>

#include "app/map_file.h"
#include "hal/error.h"
#include "nav/floor_files.h"
#include "nav/moving_ai_file.h"

namespace headway::app {

nav::VoxelMap read_map_around(const std::filesystem::path& file, const Robot& robot, const Pose2& base) {
  nav::VoxelMapConfig like = robot.mapper.voxels;
  like.lowest << base.position().array() - robot.map_margin, robot.map_height.x();
  like.highest << base.position().array() + robot.map_margin, robot.map_height.y();
  return read_map(file, like);
}

nav::FloorMap read_floor(const std::filesystem::path& file, const Robot& robot, const Pose2& start,
                         double cell) {
  const auto ending = file.extension();
  if (ending == ".yaml") return nav::read_map_server(file);
  if (ending == ".map") return nav::read_moving_ai(file, cell);
  if (ending != ".hmap" && ending != ".bt" && ending != ".ot")
    throw InputError(fmt::format(
        "{}: has an unknown ending, expected a floor map (map_server's .yaml, Moving AI's .map) or a voxel "
        "map (.hmap, .bt, .ot)",
        file.string()));
  nav::FloorMap floor = nav::floor_map(read_map_around(file, robot, start), robot.mapper.floor);
  nav::start_clear(floor, start, robot.mapper.start_area, Time{});
  return floor;
}

}  // namespace headway::app
