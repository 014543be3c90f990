// Closed meshes and coloured points as files that MeshLab, Blender or CloudCompare open.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/drawing.h"
#include "vision/hull.h"

namespace headway::app {

/// ASCII PLY and Wavefront OBJ, told by the file's ending (.ply, .obj). `comment` is one line, for the frame
/// and what is shown. The file appears whole or not at all. Throws as nav::write_whole does.
void write_mesh(const vision::TriangleMesh& mesh, const std::string& comment,
                const std::filesystem::path& file);

struct ColouredPoint {
  Eigen::Vector3d position;  ///< [m]
  Colour colour;
};
/// ASCII PLY: x y z red green blue.
void write_points(const std::vector<ColouredPoint>& points, const std::string& comment,
                  const std::filesystem::path& file);

}  // namespace headway::app
