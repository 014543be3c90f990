#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/fault_totals.h"
#include "app/finite_range.h"
#include "app/moving_totals.h"
#include "app/odometry_options.h"
#include "app/report.h"
#include "app/sim_outputs.h"
#include "app/sim_session.h"
#include "app/world_map.h"
#include "hal/error.h"
#include "sim_hal/random_faults.h"
#include "sim_hal/random_movers.h"
#include "sim_hal/random_world.h"

namespace headway::app {

namespace {

struct Options {
  int worlds = 50;
  std::optional<int> stereo;
  bool moving = false, faults = false;
  std::optional<double> frame_rate;
  std::uint64_t seed = 1;
  std::filesystem::path out = "build/campaign", robot = default_robot_file();
  std::filesystem::path world;
  double longest = 400;
  OdometryOptions odometry;
  int only = -1;
};

struct Totals {
  int runs = 0, arrived = 0, collisions = 0, falls = 0, stopped = 0;
  double goal_error = 0, odometry_error = 0;  ///< the largest [m]
  MovingTotals moving;
  FaultTotals faults;
  int unfinished = 0;  ///< neither arrived nor at rest when the time was over
};

constexpr int kStereo = 5;  // of a campaign's worlds, unless told otherwise; in those that move, none

int stereo_runs(const Options& options) {
  return options.stereo.value_or(options.moving || options.faults ? 0 : kStereo);
}

/// Faults at any time of a walk that leads straight to the goal.
sim::FaultPlan faults_for(const Robot& robot, const sim::World& world, std::uint64_t seed) {
  const double straight = world.goal ? (world.goal->position - world.start.position()).norm() : 0;
  sim::RandomFaultsConfig config;
  config.walk = seconds(straight / robot.mission.gait.forward * to_seconds(robot.mission.gait.step_duration));
  return sim::random_faults(seed, config);
}

sim::World world_for(const Options& options, const Robot& robot, std::uint64_t seed) {
  if (!options.world.empty()) return read_world_for(robot, options.world);
  return options.moving ? sim::random_moving_world(seed) : sim::random_world(seed);
}

/// One run; its row for the report. Pictures are kept of runs that did not arrive.
Json run_one(const Options& options, const Robot& robot, int number, OutputFolder& out, Totals& totals) {
  const std::uint64_t seed = options.seed * 1000 + static_cast<std::uint64_t>(number);
  const sim::World world = world_for(options, robot, seed);
  SimOptions sim;
  sim.range_mode = number >= stereo_runs(options);
  sim.seed = seed;
  sim.longest = seconds(options.longest);
  options.odometry.apply_to(sim);
  if (options.faults) sim.faults = faults_for(robot, world, seed);
  SimSession session(robot, world, sim);
  SimOutputs outputs(session);
  const SimOutcome outcome = session.run();
  if (!outcome.arrived || options.only >= 0) {
    OutputFolder below = out.below(fmt::format("world_{:03}", number));
    outputs.write(outcome, below);
  }
  ++totals.runs;
  totals.arrived += outcome.arrived;
  totals.collisions += outcome.collision.has_value();
  totals.falls += outcome.fallen;
  totals.stopped += outcome.end == "stopped";
  totals.unfinished += outcome.end == "time";
  totals.goal_error = std::max(totals.goal_error, outcome.goal_error);
  totals.odometry_error = std::max(totals.odometry_error, outcome.odometry_error);
  totals.moving.add(session);
  totals.faults.add(session.faults());
  Json row = sim_report(session, outcome);
  row.erase("steps");
  Json with_number = {{"number", number}};
  with_number.update(row);
  return with_number;
}

bool good(const Options& options, const Totals& totals) {
  if (totals.runs == 0 || totals.collisions > 0 || totals.falls > 0) return false;
  if (options.faults) return totals.unfinished == 0 && totals.faults.good();
  const int least = options.moving ? 99 : 95;  // % of the runs
  return totals.arrived * 100 >= totals.runs * least && (!options.moving || totals.moving.good());
}

int run(const Options& options) {
  if (options.only >= options.worlds)
    throw InputError(fmt::format("--only: is {}, expected 0 to {} (one of the worlds that --worlds asks for)",
                                 options.only, options.worlds - 1));
  Robot robot = read_robot(options.robot);
  if (options.frame_rate) robot.simulation.frame_rate = *options.frame_rate;
  OutputFolder out(options.out, "campaign");
  out.keep();  // each world's folder is whole by itself
  Totals totals;
  Json rows = Json::array();
  for (int number = 0; number < options.worlds; ++number) {
    if (options.only >= 0 && number != options.only) continue;
    rows.push_back(run_one(options, robot, number, out, totals));
    const Json& row = rows.back();
    fmt::print("{:3} {:6} {:9} goal error {:.3f} m, odometry off {:.3f} m, map off {:.3f} m, {:.1f} s{}{}\n",
               number, row["sight"].get<std::string>(), row["end"].get<std::string>(),
               row["goal_error_m"].get<double>(), row["odometry_error_m"].get<double>(),
               row["map_error_m"].get<double>(), row["simulated_s"].get<double>(),
               row["reason"].get<std::string>().empty() ? "" : ": ", row["reason"].get<std::string>());
    std::fflush(stdout);
  }
  Json report = {{"seed", options.seed},
                 {"runs", totals.runs},
                 {"arrived", totals.arrived},
                 {"collisions", totals.collisions},
                 {"falls", totals.falls},
                 {"stopped", totals.stopped},
                 {"goal_error_max_m", rounded(totals.goal_error)},
                 {"odometry_error_max_m", rounded(totals.odometry_error)}};
  if (options.moving) report["moving"] = totals.moving.report();
  if (options.faults) {
    report["unfinished"] = totals.unfinished;
    report["faults"] = totals.faults.report();
  }
  report["rows"] = rows;
  out.report(report);
  fmt::print(
      "{} runs: {} arrived, {} collisions, {} falls, {} stopped with a reason; goal error at most "
      "{:.3f} m, odometry off by {:.3f} m at most; {}\n",
      totals.runs, totals.arrived, totals.collisions, totals.falls, totals.stopped, totals.goal_error,
      totals.odometry_error, out.list());
  if (options.moving) fmt::print("{}\n", totals.moving.line());
  if (options.faults) fmt::print("{}", totals.faults.table());
  return good(options, totals) ? kSuccess : kNotReached;
}

}  // namespace

void add_campaign(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("campaign", "Send the simulated robot through many random worlds");
  command->add_option("--worlds", options->worlds, "How many")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--world", options->world, "Walk in this world each time, in place of random ones");
  command
      ->add_flag("--moving", options->moving,
                 "Things come onto the way while the robot walks, and leave it; judges how it answers")
      ->excludes("--world");
  command
      ->add_flag(
          "--faults", options->faults,
          "One to three things go wrong on each walk, of every kind that the simulator knows; judges how "
          "the robot answers")
      ->excludes("--moving");
  command->add_option("--frame-rate", options->frame_rate, "Of the cameras [Hz]; default: the robot file's")
      ->check(finite_in(1, 60));
  options->odometry.add_to(*command);
  command
      ->add_option(
          "--stereo", options->stereo,
          "The first so many with images and matcher, the others in range mode; 5, with --moving and "
          "--faults 0, unless given")
      ->check(CLI::Range(0, 100000));
  command->add_option("--seed", options->seed, "Seed of the worlds and of all noise")
      ->check(seed_number())
      ->capture_default_str();
  command->add_option("--out", options->out, kOutHelp)->capture_default_str();
  command->add_option("--robot", options->robot, "Robot file")->capture_default_str();
  command->add_option("--only", options->only, "Run just this one of the worlds, with pictures")
      ->check(CLI::Range(0, 99999));
  command->add_option("--longest", options->longest, "Give a run up after so many simulated seconds")
      ->check(finite_in(1, 36000))
      ->capture_default_str();
  command->footer(
      "Example: headway campaign --worlds 50 --seed 1 --out build/campaign\n"
      "Writes report.json, and world_NNN/ with all that 'headway sim' writes for each run that did not "
      "arrive.\n"
      "Exit code 0 when nothing collided or fell and 95 % arrived, else 1. With --moving, 99 % must arrive, "
      "half of the robots must see something move and replan, within one frame in 99 % of the cases where it "
      "is on their steps, everything that moved must have been in sight for the stopping time before it "
      "could be touched, and "
      "the true body must stay inside the planner's masks. With --faults, every run must end at rest, and "
      "every "
      "fault that asks for a reaction must get it in time, whether or not the robot arrives.");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
