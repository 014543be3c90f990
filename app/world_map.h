// The map that a robot needs for a simulated world: the box around the world's floor.
#pragma once

#include <filesystem>

#include "app/robot_file.h"
#include "nav/voxel_map.h"
#include "sim_hal/world.h"

namespace headway::app {

/// The robot's voxels around the world's floor and its margin; not validated.
nav::VoxelMapConfig map_box(const Robot& robot, const sim::World& world);

/// A world file for this robot. Throws InputError `file:line: key: what, expected what`, also where its floor
/// asks for a map that would not fit into memory.
sim::World read_world_for(const Robot& robot, const std::filesystem::path& file);

}  // namespace headway::app
