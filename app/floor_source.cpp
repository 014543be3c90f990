#include "app/floor_source.h"

#include <fmt/format.h>

#include "app/file_kind.h"
#include "app/map_file.h"
#include "app/whole_map.h"
#include "hal/angle.h"
#include "hal/error.h"
#include "nav/floor_files.h"
#include "nav/moving_ai_file.h"

namespace headway::app {

Eigen::AlignedBox2d area_of(const nav::FloorGrid& grid) {
  return {grid.origin, grid.origin + grid.resolution * Eigen::Vector2d(grid.width, grid.height)};
}

void require_inside(const Eigen::AlignedBox2d& area, const GivenPlace& place) {
  if (area.contains(place.at.position())) return;
  throw InputError(fmt::format(
      "{}: ({:g}, {:g}) lies outside of the map, expected x from {:g} to {:g} and y from {:g} to {:g} m",
      place.option, place.at.x, place.at.y, area.min().x(), area.max().x(), area.min().y(), area.max().y()));
}

void require_standing(const nav::FloorMap& floor, const nav::BodyOutline& outline, const GivenPlace& place) {
  const Pose2& at = place.at;
  if (floor.at(floor.grid.cell(at.position())) == nav::Floor::kBlocked)
    throw InputError(
        fmt::format("{}: ({:g}, {:g}) lies in an obstacle, expected free floor", place.option, at.x, at.y));
  const Eigen::Array2d body(outline.half_depth, outline.half_width);
  const Pose2 body_from_map = at.inverse();
  for (const Eigen::Vector2i& cell : nav::body_cells(floor.grid, outline.bare(), at)) {
    const Eigen::Vector2d centre = floor.grid.centre(cell);
    if (floor.at(cell) != nav::Floor::kBlocked || ((body_from_map * centre).array().abs() > body).any())
      continue;
    throw InputError(fmt::format(
        "{}: at ({:g}, {:g}), facing {:g} deg, the body meets an obstacle at ({:.2f}, {:.2f}), expected free "
        "floor under {:g} x {:g} m",
        place.option, at.x, at.y, at.yaw / kDegree, centre.x(), centre.y(), 2 * body.x(), 2 * body.y()));
  }
}

nav::VoxelMap read_map_around(const std::filesystem::path& file, const Robot& robot, const GivenPlace& base) {
  const nav::ColdMap known = read_known(file);
  const Eigen::AlignedBox3d extent = extent_of(known);
  const Eigen::Vector2d room = Eigen::Vector2d::Constant(robot.map_margin);
  require_inside({extent.min().head<2>() - room, extent.max().head<2>() + room}, base);
  nav::VoxelMapConfig like = robot.mapper.voxels;
  like.lowest << base.at.position() - room, robot.map_height.x();
  like.highest << base.at.position() + room, robot.map_height.y();
  return voxels_of(known, like, file);
}

namespace {

nav::FloorMap read_floor_file(const std::filesystem::path& file, double cell) {
  if (file.extension() == ".map") return nav::read_moving_ai(file, cell);
  require_kind(file, FileKind::kFloorMap);
  return nav::read_map_server(file);
}

}  // namespace

nav::FloorMap read_floor(const std::filesystem::path& file, const Robot& robot, const GivenPlace& start,
                         double cell) {
  const nav::BodyOutline& outline = robot.mission.outline;
  const auto ending = file.extension();
  if (ending == ".yaml" || ending == ".map") {
    nav::FloorMap floor = read_floor_file(file, cell);
    require_inside(area_of(floor.grid), start);
    require_standing(floor, outline, start);
    return floor;
  }
  if (ending != ".hmap" && ending != ".bt" && ending != ".ot")
    throw InputError(fmt::format(
        "{}: has an unknown ending, expected a floor map (map_server's .yaml, Moving AI's .map) or a voxel "
        "map (.hmap, .bt, .ot)",
        file.string()));
  nav::FloorMap floor = nav::floor_map(read_map_around(file, robot, start), robot.mapper.floor);
  require_standing(floor, outline, start);
  nav::start_clear(floor, start.at, robot.mapper.start_area, Time{});
  return floor;
}

}  // namespace headway::app
