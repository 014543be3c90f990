#include "vision/hull.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <libqhull_r/libqhull_r.h>

#include "hal/error.h"

namespace headway::vision {

namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

// One run of qhull. Its own account of errors goes to memory, not to the terminal.
class Hull {
 public:
  Hull(const std::vector<Vector3d>& points, const char* options) : points_(points) {
    if (points_.size() < 4) refuse("expected at least 4");
    qh_zero(&qh_, log_.file);
    std::string command = options;
    const int code = qh_new_qhull(&qh_, 3, static_cast<int>(points_.size()), points_.front().data(), False,
                                  command.data(), nullptr, log_.file);
    if (code != qh_ERRnone) {
      release();
      refuse(fmt::format("qhull's error {}", code));
    }
  }
  ~Hull() { release(); }
  Hull(const Hull&) = delete;
  Hull& operator=(const Hull&) = delete;

  /// `use(index, point)` for each vertex.
  template <class Use>
  void for_each_vertex(const Use& use) {
    for (vertexT* v = qh_.vertex_list; v && v->next; v = v->next) use(index(v), Vector3d(v->point));
  }
  /// `use(row, corners)` for each facet: its plane as a row of A, and the indices of its vertices.
  template <class Use>
  void for_each_facet(const Use& use) {
    for (facetT* f = qh_.facet_list; f && f->next; f = f->next) {
      // qhull's normals have unit length and point outwards.
      const Vector4d row(-f->normal[0], -f->normal[1], -f->normal[2], -f->offset);
      std::vector<std::size_t> corners;
      for (int i = 0; i < qh_setsize(&qh_, f->vertices); ++i)
        corners.push_back(index(static_cast<vertexT*>(SETelem_(f->vertices, i))));
      use(row, corners);
    }
  }

 private:
  struct Log {
    char* text = nullptr;
    std::size_t size = 0;
    std::FILE* file = open_memstream(&text, &size);
    ~Log() {
      if (file) std::fclose(file);
      std::free(text);
    }
  };

  std::size_t index(const vertexT* vertex) {
    return static_cast<std::size_t>(qh_pointid(&qh_, vertex->point));
  }
  void release() {
    int left = 0, bytes = 0;
    qh_freeqhull(&qh_, qh_ALL);
    qh_memfreeshort(&qh_, &left, &bytes);
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError(fmt::format("hull: {} points span no volume ({})", points_.size(), why));
  }

  std::vector<Vector3d> points_;  // qhull keeps pointers into them
  Log log_;
  qhT qh_{};
};

}  // namespace

Polytope hull_polytope(const std::vector<Vector3d>& points) {
  Hull hull(points, "qhull");
  Polytope out;
  hull.for_each_facet([&](const Vector4d& row, const auto&) { out.rows.push_back(row); });
  hull.for_each_vertex([&](std::size_t, const Vector3d& corner) { out.corners.push_back(corner); });
  return out;
}

TriangleMesh hull_mesh(const std::vector<Vector3d>& points) {
  Hull hull(points, "qhull Qt");
  TriangleMesh mesh;
  std::map<std::size_t, std::size_t> place;  // of a point among the mesh's corners
  hull.for_each_vertex([&](std::size_t index, const Vector3d& corner) {
    place[index] = mesh.corners.size();
    mesh.corners.push_back(corner);
  });
  hull.for_each_facet([&](const Vector4d& row, const std::vector<std::size_t>& corners) {
    std::array<std::size_t, 3> t{place.at(corners.at(0)), place.at(corners.at(1)), place.at(corners.at(2))};
    const Vector3d &a = mesh.corners[t[0]], &b = mesh.corners[t[1]], &c = mesh.corners[t[2]];
    if ((b - a).cross(c - a).dot(row.head<3>()) > 0) std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  });
  return mesh;
}

std::vector<Vector4d> merged(const std::vector<Vector4d>& rows, double angle, double offset) {
  std::vector<Vector4d> kept;
  for (const Vector4d& row : rows) {
    bool stands = true;
    for (const Vector4d& other : kept)
      stands &=
          row.head<3>().dot(other.head<3>()) < std::cos(angle) || std::abs(row.w() - other.w()) > offset;
    if (stands) kept.push_back(row);
  }
  return kept;
}

Polytope minimal_polytope(const std::vector<Vector4d>& rows, const Vector3d& inside) {
  std::vector<Vector3d> dual;
  for (const Vector4d& row : rows) {
    const double distance = row.dot(inside.homogeneous());
    if (!(distance > 0)) throw InputError("minimal polytope: the point inside lies on a plane or beyond it");
    dual.emplace_back(row.head<3>() / distance);
  }
  Hull hull(dual, "qhull");
  Polytope out;
  hull.for_each_vertex([&](std::size_t index, const Vector3d&) { out.rows.push_back(rows[index]); });
  // A facet of the dual is n y + o >= 0 for all dual points y; o > 0 when the set is bounded.
  hull.for_each_facet([&](const Vector4d& plane, const auto&) {
    if (!(plane.w() > 1e-9)) throw InputError("minimal polytope: the half-spaces leave it endless");
    out.corners.emplace_back(inside + plane.head<3>() / plane.w());
  });
  return out;
}

}  // namespace headway::vision
