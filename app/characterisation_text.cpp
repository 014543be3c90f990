#include "app/characterisation_text.h"

#include <fmt/format.h>

#include "hal/angle.h"

namespace headway::app {

namespace {

void print_field(const Characterisation& c) {
  const auto sizes = [](const char* name, const std::array<vision::PolytopeSize, 3>& s) {
    fmt::print("  {:<34}{:>8}{:>8}{:>8}   {} corners\n", name, s[0].rows, s[1].rows, s[2].rows, s[2].corners);
  };
  fmt::print("The field: half-spaces of the minimal A x >= 0\n  {:<34}{:>8}{:>8}{:>8}\n", "depth limits",
             "none", "near", "both");
  sizes("rectified (what the program sees)", c.rig.rectified_sizes);
  sizes("as the cameras are mounted", c.rig.mounted_sizes);
  fmt::print(
      "  from {:g} to {:g} m it holds {:.2f} m^3; a matcher that leaves its first {} columns out loses "
      "{:.0f} %\n",
      c.raw.nearest, c.raw.farthest, vision::volume(c.rig.field), c.rig.matcher_columns,
      100 * c.rig.padded_share);
  fmt::print("The paper's way: {} pixel pairs, {} points between those depths\n", c.rig.pairs.pairs,
             c.rig.pairs.points.size());
  fmt::print("  {:<34}{:>8}{:>8}\n", "", "here", "paper");
  fmt::print("  {:<34}{:>8}{:>8}\n", "Quickhull: vertices of the hull", c.rig.pairs.hull.corners.size(), 250);
  fmt::print("  {:<34}{:>8}{:>8}\n", "minimal form: half-spaces", c.rig.pairs.minimal.rows.size(), 132);
  fmt::print(
      "  (of {} facets; near-parallel ones are merged at 0.2 deg and 5 mm: without that none is "
      "redundant)\n\n",
      c.rig.pairs.hull.rows.size());
}

void print_sight(const Characterisation& c) {
  const std::vector<double> at = telling_depths(c.raw);
  fmt::print("{:<36}", "Depth [m]");
  for (const double z : at) fmt::print("{:>8}", z < kFarAway ? fmt::format("{:g}", z) : "far");
  fmt::print("{:>8}\n  {:<34}", "paper", "field of view, left to right [deg]");
  for (const double z : at)
    fmt::print("{:>8.1f}", vision::field_angles(c.rig.rectified, z).horizontal / kDegree);
  fmt::print("{:>8}\n  {:<34}", 33, "field of view, up and down [deg]");
  for (const double z : at)
    fmt::print("{:>8.1f}", vision::field_angles(c.rig.rectified, z).vertical / kDegree);
  fmt::print("{:>8}\n  {:<34}", 33, "resolution on the axis [mm]");
  for (const double z : at)
    if (z < kFarAway)
      fmt::print("{:>8.1f}", 1e3 * vision::resolution(c.rig.rectified, vision::on_axis(c.rig.rectified, z)));
  fmt::print("\n");
  for (const auto& resolved : c.rig.resolved)
    fmt::print("  {:<34}{:>8.2f} m, {:.2f} m^3\n",
               fmt::format("seen to {:g} mm: up to", resolved.resolution * 1e3), resolved.farthest,
               vision::volume(resolved.polytope));
  fmt::print("\n");
}

void print_tours(const Characterisation& c) {
  const hal::HeadLimits& l = c.robot.mission.head;
  fmt::print("Looking around with a head of {:.0f} x {:.0f} deg ({}): share [%] shown\n",
             (l.upper.pan - l.lower.pan) / kDegree, (l.upper.tilt - l.lower.tilt) / kDegree, c.robot.name);
  fmt::print("  {:<28}{:>6}{:>16}{:>20}\n", "", "", "of its gaze", "of all it can show");
  fmt::print("  {:<28}{:>6}{:>9}{:>7}{:>13}{:>7}\n", "laid out for", "views", "far", "1 m", "far", "1 m");
  for (const CoveredTour& t : c.tours)
    fmt::print("  {:<28}{:>6}{:>9.0f}{:>7.0f}{:>13.0f}{:>7.0f}\n", t.laid_out_for, t.views.size(),
               100 * t.far_away.gaze, 100 * t.at_a_metre.gaze, 100 * t.far_away.reach,
               100 * t.at_a_metre.reach);
}

}  // namespace

void print_characterisation(const Characterisation& c) {
  const vision::RectifiedRig& r = c.rig.rectified;
  fmt::print("{}: two cameras of {} x {} px, {:.3f} m apart; rectified focal length {:.1f} px\n\n",
             c.raw.name, c.raw.left.width, c.raw.left.height, c.raw.baseline(), r.camera.focal);
  print_field(c);
  print_sight(c);
  print_tours(c);
}

}  // namespace headway::app
