#include "vision/field.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace headway::vision {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kTolerance = 1e-9;  // [m]: a point this far outside counts as on the plane

Vector4d plane(double a, double b, double c, double d) {
  return Vector4d(a, b, c, d) / Vector3d(a, b, c).norm();
}

// All half-spaces of both images and both depths, redundant ones among them.
std::vector<Vector4d> all_rows(const RectifiedRig& rig, double near, double far) {
  const PinholeCamera& c = rig.camera;
  const double f = c.focal, left = -0.5 - c.cx,
               right = c.width - 0.5 - c.cx;  // image edges from the axis [px]
  const double o = rig.disparity_offset, b = rig.baseline;
  return {plane(f, 0, -left, 0),           // u_left >= -1/2
          plane(-f, 0, right, 0),          // u_left <= width - 1/2
          plane(f, 0, o - left, -f * b),   // u_right >= -1/2, with u_right = f (x - B) / z + cx + offset
          plane(-f, 0, right - o, f * b),  // u_right <= width - 1/2
          plane(0, f, 0.5 + c.cy, 0),      // v >= -1/2
          plane(0, -f, c.height - 0.5 - c.cy, 0),  // v <= height - 1/2
          plane(0, 0, 1, -near),
          plane(0, 0, -1, far)};
}

bool inside(const std::vector<Vector4d>& rows, const Vector3d& p) {
  return std::all_of(rows.begin(), rows.end(),
                     [&](const Vector4d& r) { return r.dot(p.homogeneous()) >= -kTolerance; });
}

void add_once(std::vector<Vector3d>& corners, const Vector3d& p) {
  for (const Vector3d& q : corners)
    if ((p - q).norm() < 10 * kTolerance) return;
  corners.push_back(p);
}

// Every vertex is where three planes meet; with so few planes all triples can be tried.
std::vector<Vector3d> vertices(const std::vector<Vector4d>& rows) {
  std::vector<Vector3d> corners;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = i + 1; j < rows.size(); ++j)
      for (std::size_t k = j + 1; k < rows.size(); ++k) {
        Matrix3d normals;
        normals << rows[i].head<3>().transpose(), rows[j].head<3>().transpose(),
            rows[k].head<3>().transpose();
        if (std::abs(normals.determinant()) < 1e-12) continue;
        const Vector3d p = normals.inverse() * -Vector3d(rows[i].w(), rows[j].w(), rows[k].w());
        if (inside(rows, p)) add_once(corners, p);
      }
  return corners;
}

// True when the corners on this plane span a face: then the row cannot be left out.
bool carries_a_face(const Vector4d& row, const std::vector<Vector3d>& corners) {
  std::vector<Vector3d> on;
  for (const Vector3d& p : corners)
    if (std::abs(row.dot(p.homogeneous())) < 10 * kTolerance) on.push_back(p);
  for (std::size_t i = 2; i < on.size(); ++i)
    if ((on[1] - on[0]).cross(on[i] - on[0]).norm() > kTolerance * kTolerance) return true;
  return false;
}

// Angles at the middle of cells that divide [lower, upper], or spread from end to end.
std::vector<double> spread(double lower, double upper, double step, Coverage coverage) {
  const double width = std::max(0.0, upper - lower);
  const int cells = std::max(1, static_cast<int>(std::ceil(width / step - 1e-9)));
  std::vector<double> angles;
  if (coverage == Coverage::kReach && width > 0)
    for (int i = 0; i <= cells; ++i) angles.push_back(lower + width * i / cells);
  else
    for (int i = 0; i < cells; ++i) angles.push_back(lower + width * (i + 0.5) / cells);
  return angles;
}

}  // namespace

Field field_of(const RectifiedRig& rig, double near, double far) {
  const Field nothing{{Vector4d(0, 0, 0, -1)}, {}};
  if (!(near > 0) || !(far > near) || rig.camera.width <= 0 || rig.camera.height <= 0) return nothing;
  Field field;
  const std::vector<Vector4d> rows = all_rows(rig, near, far);
  field.corners = vertices(rows);
  for (const Vector4d& row : rows) {
    const bool twice = std::any_of(field.rows.begin(), field.rows.end(),
                                   [&](const Vector4d& r) { return (r - row).norm() < 10 * kTolerance; });
    if (!twice && carries_a_face(row, field.corners)) field.rows.push_back(row);
  }
  return field.rows.size() < 4 ? nothing : field;
}

FieldAngles field_angles(const RectifiedRig& rig, double z) {
  const PinholeCamera& c = rig.camera;
  const double f = c.focal, b = rig.baseline, o = rig.disparity_offset;
  const double left = -0.5 - c.cx, right = c.width - 0.5 - c.cx;
  // Edges of the common view at depth z, from the middle of the baseline [m].
  const double x_lowest = std::max(left / f * z, (left - o) / f * z + b) - b / 2;
  const double x_highest = std::min(right / f * z, (right - o) / f * z + b) - b / 2;
  if (!(z > 0) || x_highest <= x_lowest) return {};
  return {std::atan2(x_highest, z) - std::atan2(x_lowest, z),
          std::atan((c.height - 0.5 - c.cy) / f) + std::atan((0.5 + c.cy) / f)};
}

std::vector<hal::HeadAngles> viewpoints(const hal::HeadLimits& limits, const FieldAngles& field,
                                        double overlap, Coverage coverage) {
  constexpr double kSmallest = 0.017;  // one degree: no rig is narrower, and the list stays finite
  const double share = 1 - std::clamp(overlap, 0.0, 0.9);
  std::vector<double> pans =
      spread(limits.lower.pan, limits.upper.pan, std::max(kSmallest, field.horizontal * share), coverage);
  const std::vector<double> tilts =
      spread(limits.lower.tilt, limits.upper.tilt, std::max(kSmallest, field.vertical * share), coverage);
  std::vector<hal::HeadAngles> views;
  for (const double tilt : tilts) {
    for (const double pan : pans) views.push_back({pan, tilt});
    std::reverse(pans.begin(), pans.end());
  }
  return views;
}

}  // namespace headway::vision
