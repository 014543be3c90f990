// A floor map from whatever kind of map a file holds.
#pragma once

#include <filesystem>

#include "app/robot_file.h"
#include "nav/floor_map.h"

namespace headway::app {

/// By the file's ending: .yaml (map_server), .map (Moving AI, cells of `cell` [m]), or a voxel map (.hmap,
/// .bt, .ot), projected as the robot does it, with the start at `start` vouched for. Throws InputError `file:
/// what, expected what`.
nav::FloorMap read_floor(const std::filesystem::path& file, const Robot& robot, const Pose2& start,
                         double cell);

/// A saved voxel map with room for the robot around `base`. Throws as read_map.
nav::VoxelMap read_map_around(const std::filesystem::path& file, const Robot& robot, const Pose2& base);

}  // namespace headway::app
