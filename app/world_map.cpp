#include "app/world_map.h"

#include "app/file_kind.h"
#include "config/yaml_reader.h"
#include "hal/error.h"
#include "sim_hal/world_file.h"

namespace headway::app {

nav::VoxelMapConfig map_box(const Robot& robot, const sim::World& world) {
  const double margin = robot.map_margin;
  const Eigen::Vector2d low = world.floor.centre - world.floor.size / 2,
                        high = world.floor.centre + world.floor.size / 2;
  nav::VoxelMapConfig box = robot.mapper.voxels;
  box.lowest = {low.x() - margin, low.y() - margin, robot.map_height.x()};
  box.highest = {high.x() + margin, high.y() + margin, robot.map_height.y()};
  return box;
}

sim::World read_world_for(const Robot& robot, const std::filesystem::path& file) {
  require_kind(file, FileKind::kWorld);
  const config::Section section = config::Section::load(file, "world");
  sim::World world = sim::world_from(section);
  try {
    map_box(robot, world).validate();
  } catch (const InputError& fault) {
    for (const char* part : {"floor", "room"})
      if (const auto floor = section.section_if(part)) floor->fail("size", fault.what());
    section.fail("", fault.what());
  }
  return world;
}

}  // namespace headway::app
