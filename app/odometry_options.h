// The options of commands that walk the simulated robot: how its odometry drifts, and whether it is believed.
#pragma once

#include <CLI/CLI.hpp>

#include "app/finite_range.h"
#include "app/sim_session.h"

namespace headway::app {

struct OdometryOptions {
  double drift = 0;  ///< [percent]
  bool no_localise = false;

  /// The options must outlive `command`.
  void add_to(CLI::App& command) {
    command
        .add_option(
            "--drift", drift,
            "Percent by which odometry drifts: of a stride's length, and of the widest turn with each step")
        ->check(finite_in(0, 20))
        ->capture_default_str();
    command.add_flag("--no-localise", no_localise, "Take odometry for the truth");
  }

  void apply_to(SimOptions& sim) const {
    sim.drift = drift / 100;
    sim.localise = !no_localise;
  }
};

}  // namespace headway::app
