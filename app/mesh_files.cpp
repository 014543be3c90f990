#include "app/mesh_files.h"

#include <ostream>

#include <fmt/format.h>

#include "config/yaml_limits.h"
#include "nav/whole_file.h"

namespace headway::app {

namespace {

void write_text(const std::string& text, const std::filesystem::path& file) {
  nav::write_whole(file, [&](std::ostream& out) { out << text; });
}

std::string ply_header(const std::string& comment, std::size_t points) {
  return fmt::format(
      "ply\nformat ascii 1.0\ncomment {}\nelement vertex {}\nproperty float x\nproperty float y\nproperty "
      "float "
      "z\n",
      config::one_line(comment), points);
}

std::string ply_of(const vision::TriangleMesh& mesh, const std::string& comment) {
  std::string text = ply_header(comment, mesh.corners.size());
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                      mesh.triangles.size());
  for (const auto& p : mesh.corners) text += fmt::format("{:.6g} {:.6g} {:.6g}\n", p.x(), p.y(), p.z());
  for (const auto& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  return text;
}

std::string obj_of(const vision::TriangleMesh& mesh, const std::string& comment) {
  std::string text = "# " + config::one_line(comment) + "\n";
  for (const auto& p : mesh.corners) text += fmt::format("v {:.6g} {:.6g} {:.6g}\n", p.x(), p.y(), p.z());
  for (const auto& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

}  // namespace

void write_mesh(const vision::TriangleMesh& mesh, const std::string& comment,
                const std::filesystem::path& file) {
  write_text(file.extension() == ".obj" ? obj_of(mesh, comment) : ply_of(mesh, comment), file);
}

void write_points(const std::vector<ColouredPoint>& points, const std::string& comment,
                  const std::filesystem::path& file) {
  std::string text = ply_header(comment, points.size());
  text += "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  for (const ColouredPoint& p : points)
    text += fmt::format("{:.6g} {:.6g} {:.6g} {} {} {}\n", p.position.x(), p.position.y(), p.position.z(),
                        p.colour[2], p.colour[1], p.colour[0]);
  write_text(text, file);
}

}  // namespace headway::app
