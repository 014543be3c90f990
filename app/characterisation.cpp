#include "app/characterisation.h"

#include <algorithm>
#include <cmath>

#include "hal/angle.h"
#include "vision/rectify.h"

namespace headway::app {

namespace {

void plan_tours(Characterisation& c) {
  using vision::Coverage;
  const hal::HeadLimits& limits = c.robot.mission.head;
  const auto plan = [&](const char* what, const vision::FieldAngles& angles, Coverage coverage) {
    CoveredTour tour{what, vision::viewpoints(limits, angles, 0, coverage), {}, {}};
    tour.far_away = vision::covered(c.endless, c.robot.mission.neck, limits, tour.views, kFarAway);
    tour.at_a_metre = vision::covered(c.endless, c.robot.mission.neck, limits, tour.views, 1);
    c.tours.push_back(std::move(tour));
  };
  const vision::FieldAngles far_away = vision::field_angles(c.rig.rectified, kFarAway),
                            near_by = vision::field_angles(c.rig.rectified, 1);
  plan("the paper's 33 x 33 deg", {33 * kDegree, 33 * kDegree}, Coverage::kGaze);
  plan("gaze, far away", far_away, Coverage::kGaze);
  if (near_by.horizontal > 0) plan("gaze, at 1 m", near_by, Coverage::kGaze);
  plan("all it can show, far away", far_away, Coverage::kReach);
  if (near_by.horizontal > 0) plan("all it can show, at 1 m", near_by, Coverage::kReach);
}

}  // namespace

Characterisation characterised(const vision::StereoRig& rig, const std::filesystem::path& robot,
                               const std::vector<double>& resolutions,
                               const std::optional<Eigen::Isometry3d>& tilt_from_left) {
  Characterisation c;
  c.raw = rig;
  c.robot = read_robot(robot);
  if (tilt_from_left) c.robot.mission.neck.tilt_from_camera = *tilt_from_left;
  const vision::Rectifier rectifier(rig);
  c.left_from_rectified = rectifier.rectified_from_left().inverse();
  c.rig = vision::characterise(rectifier, resolutions);
  c.endless = vision::moved(vision::rig_polytope(c.rig.rectified, {}), c.left_from_rectified);
  plan_tours(c);
  return c;
}

std::vector<double> telling_depths(const vision::StereoRig& rig) {
  std::vector<double> out{rig.nearest, rig.farthest};
  for (const double z : {0.5, 1.0, 2.0, 5.0})
    if (std::abs(z - rig.nearest) > 0.1 * z && std::abs(z - rig.farthest) > 0.1 * z) out.push_back(z);
  std::sort(out.begin(), out.end());
  out.push_back(kFarAway);
  return out;
}

}  // namespace headway::app
