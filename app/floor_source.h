// A floor map from whatever kind of map a file holds.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>

#include "app/robot_file.h"
#include "nav/floor_map.h"

namespace headway::app {

/// A place that a user gave.
struct GivenPlace {
  const char* option;  ///< for messages
  Pose2 at;
};

/// Where a robot stands: by the file's ending on a .yaml (map_server), .map (Moving AI, cells of `cell` [m]),
/// or voxel map (.hmap, .bt, .ot), projected as the robot does it, with what is unseen around `start` vouched
/// for. Throws InputError `file: what, expected what`, and where a robot cannot stand at `start`.
nav::FloorMap read_floor(const std::filesystem::path& file, const Robot& robot, const GivenPlace& start,
                         double cell);

/// A saved voxel map with room for the robot around `base`. Throws as read_map, and where `base` lies off it
/// by more than the room.
nav::VoxelMap read_map_around(const std::filesystem::path& file, const Robot& robot, const GivenPlace& base);

/// Throws InputError where the place lies outside.
void require_inside(const Eigen::AlignedBox2d& area, const GivenPlace& place);
Eigen::AlignedBox2d area_of(const nav::FloorGrid& grid);

/// Throws InputError where a robot cannot stand there: an obstacle is where its body is.
void require_standing(const nav::FloorMap& floor, const nav::BodyOutline& outline, const GivenPlace& place);

}  // namespace headway::app
