// What the robot's feet can do, how long a step takes, and what that makes of walking times.
#pragma once

#include <numbers>
#include <optional>

#include "hal/footstep.h"
#include "nav/walking/walking_pattern.h"

namespace headway::nav {

/// What is low enough is stepped over, with longer, higher and slower steps.
struct StepOverLimits {
  double height = 0;      ///< of what may be stepped over [m]; 0: nothing is
  double forward = 0.45;  ///< the landing foot ahead of the standing one [m]
  double margin = 0.03;   ///< from soles to cells where something stands [m]
  Duration duration = seconds(1.4);
  double cost = 2;  ///< to the planner, of each low cell that the base passes over [s]
};

/// Limits of one step. HRP-2's numbers; the pattern generator and the control computer know the same.
struct GaitLimits {
  double feet_apart = 0.19;      ///< from sole centre to sole centre when parallel [m]
  double forward = 0.20;         ///< the landing foot ahead of the standing one [m]
  double forward_on_arc = 0.15;  ///< the same when the step turns by more than `arc_begins` [m]
  double arc_begins = 0.0175;    ///< [rad]
  double backward = 0.02;  ///< the landing foot behind the standing one (turning in place asks for it) [m]
  double outward = 0.05;   ///< the landing foot wider than feet_apart [m]
  double inward = 0.01;    ///< the landing foot closer than feet_apart [m]
  double yaw = 5 * std::numbers::pi / 180;  ///< between the feet [rad]
  Duration step_duration = seconds(0.8);
  double sole_length = 0.2172, sole_width = 0.138;  ///< [m], centred on the foot's frame
  StepOverLimits over;
  double zmp_margin = 0.01;  ///< of the pattern's ZMP inside the soles, all along a plan [m]

  /// The most a step may turn in units of the wire (2 mrad) [rad].
  double yaw_on_the_wire() const;
  /// Time to turn in place by `angle` [rad], to walk straight on, and to walk sideways [s].
  double turn_seconds(double angle) const;
  double forward_seconds(double metres) const;
  double sideway_seconds(double metres) const;

  /// Throws InputError `gait: key: what, expected what` for limits that no step could keep.
  void validate() const;
};

/// The pattern generator that walks such steps.
WalkingConfig walking_config(const GaitLimits& limits);

/// The base as carried by the foot that landed last (the planner's start while walking); at rest, the base
/// midway between the feet.
Pose2 gait_base(const hal::Stance& stance, std::optional<hal::Foot> last_foot, const GaitLimits& gait);

/// Whether a step keeps the limits (to a tenth of a millimetre).
bool within_limits(const hal::Footstep& step, const GaitLimits& limits);

}  // namespace headway::nav
