// Where to look next: what shows most unseen space per second that it takes to turn the head there, or to
// walk first.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "hal/head_kinematics.h"
#include "hal/pose2.h"
#include "nav/floor_map.h"
#include "nav/planner.h"
#include "nav/view_gain.h"
#include "nav/voxel_map.h"
#include "nav/walking/gait.h"
#include "vision/polytope.h"

namespace headway::nav {

/// The robot as one that looks.
struct Viewer {
  vision::Polytope field;  ///< of the rig, in the left camera's optical frame
  hal::HeadKinematics neck;
  hal::HeadLimits head;
  double chest_height = 1.0;  ///< where it stands [m]
};

struct NextViewConfig {
  UsefulSpace space;
  double least_gain = 0.1;      ///< a look that shows less unseen space is not worth taking [m^3]
  double look_seconds = 0.3;    ///< that a look takes once the head is there [s]
  double stance_spacing = 0.5;  ///< between the places from where to look [m]
  double stance_range = 2.0;    ///< how far away they may be [m]

  /// Throws InputError `next view: key: what, expected what`.
  void validate() const;
};

struct NextLook {
  hal::HeadAngles head;
  std::optional<Pose2> stance;  ///< of the base, to walk to first; nothing: from here
  double gain = 0;              ///< useful unseen space that it shows at most [m^3]
  double seconds = 0;           ///< of turning the head or walking, and of looking
  double rate() const { return gain / seconds; }
};

/// Time that the head needs from rest to rest, both joints at once [s].
double head_seconds(const hal::HeadAngles& from, const hal::HeadAngles& to, const hal::HeadLimits& limits);

class NextView {
 public:
  /// Throws InputError when config or field are unusable.
  NextView(const Viewer& viewer, double resolution, const NextViewConfig& config = {});

  /// Looks from where the robot stands, with the head at `head` now: those that are worth taking, most gain
  /// per second first. `looked`: poses of the left camera from here that were looked from already
  /// (ViewGain::gain). Of equal looks the earlier direction comes first.
  std::vector<NextLook> turns(const VoxelMap& map, const Eigen::Isometry3d& map_from_chest,
                              const hal::HeadAngles& head, std::span<const Eigen::Isometry3d> looked = {});

  /// Walks to places of free floor that the planner reaches from `base`, each with one look straight ahead:
  /// the `most` best of those that are worth taking, most gain per second first.
  std::vector<NextLook> walks(const VoxelMap& map, const FloorMap& floor, Planner& planner,
                              const GaitLimits& gait, const Pose2& base, std::size_t most);

  /// The directions of the head that are tried: all over its limits, half a field apart.
  const std::vector<hal::HeadAngles>& directions() const { return directions_; }
  const Viewer& viewer() const { return viewer_; }

 private:
  double gain(const VoxelMap& map, const Eigen::Isometry3d& map_from_chest, const hal::HeadAngles& head,
              std::span<const Eigen::Isometry3d> looked);
  NextLook best_ahead(const VoxelMap& map, const Pose2& stance);

  Viewer viewer_;
  NextViewConfig config_;
  ViewGain gain_;
  std::vector<double> tilts_;
  std::vector<hal::HeadAngles> directions_;
};

}  // namespace headway::nav
