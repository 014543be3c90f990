#include "vision/viewpoints.h"

#include <algorithm>
#include <cmath>

namespace headway::vision {

namespace {

using Eigen::Vector3d;

constexpr double kSmallest = 0.017;  // one degree: no rig is narrower, and lists stay finite

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

// Evenly spread directions (a Fibonacci lattice on the sphere).
std::vector<Vector3d> lattice_directions(int count) {
  const double golden = M_PI * (1 + std::sqrt(5.0));
  std::vector<Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - z * z);
    directions.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return directions;
}

bool any_contains(const std::vector<Polytope>& polytopes, const Vector3d& point) {
  return std::any_of(polytopes.begin(), polytopes.end(),
                     [&](const Polytope& p) { return p.contains(point); });
}

// Angles from `lower` to `upper`, both among them, so close that fields overlap by far.
std::vector<double> dense(double lower, double upper) {
  constexpr double kStep = 0.1;  // [rad]
  const int steps = std::max(1, static_cast<int>(std::ceil((upper - lower) / kStep)));
  std::vector<double> angles;
  for (int i = 0; i <= steps; ++i) angles.push_back(lower + (upper - lower) * i / steps);
  return angles;
}

bool within(const hal::HeadAngles& a, const hal::HeadLimits& limits) {
  return a.pan >= limits.lower.pan && a.pan <= limits.upper.pan && a.tilt >= limits.lower.tilt &&
         a.tilt <= limits.upper.tilt;
}

}  // namespace

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

std::vector<hal::HeadAngles> all_directions(const hal::HeadLimits& limits) {
  std::vector<hal::HeadAngles> all;
  for (const double pan : dense(limits.lower.pan, limits.upper.pan))
    for (const double tilt : dense(limits.lower.tilt, limits.upper.tilt)) all.push_back({pan, tilt});
  return all;
}

std::vector<Polytope> fields_of(const Polytope& field, const hal::HeadKinematics& neck,
                                const std::vector<hal::HeadAngles>& views) {
  std::vector<Polytope> fields;
  for (const hal::HeadAngles& view : views) fields.push_back(moved(field, neck.chest_from_camera(view)));
  return fields;
}

CoveredShares covered(const Polytope& field, const hal::HeadKinematics& neck, const hal::HeadLimits& limits,
                      const std::vector<hal::HeadAngles>& views, double distance) {
  constexpr int kDirections = 3000;
  const std::vector<Polytope> chosen = fields_of(field, neck, views);
  const std::vector<Polytope> any = fields_of(field, neck, all_directions(limits));
  const Vector3d centre = (neck.chest_from_pan * neck.pan_from_tilt).translation();
  int gaze = 0, gaze_seen = 0, reach = 0, reach_seen = 0;
  for (const Vector3d& direction : lattice_directions(kDirections)) {
    const Vector3d point = centre + distance * direction;
    const bool seen = any_contains(chosen, point);
    const bool looked_at = within(neck.look_at(point), limits);
    const bool reached = seen || any_contains(any, point);
    gaze += looked_at, gaze_seen += looked_at && seen;
    reach += reached, reach_seen += seen;
  }
  return {static_cast<double>(gaze_seen) / std::max(gaze, 1),
          static_cast<double>(reach_seen) / std::max(reach, 1)};
}

}  // namespace headway::vision
