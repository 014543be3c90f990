#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/finite_range.h"
#include "app/odometry_options.h"
#include "app/output_folder.h"
#include "app/patrol.h"
#include "app/world_map.h"
#include "hal/error.h"

namespace headway::app {

namespace {

struct Options {
  std::filesystem::path world, out, robot = default_robot_file();
  double hours = 8, frame_rate = 0;
  std::uint64_t seed = 0;
  bool stereo = false;
  OdometryOptions odometry;
};

std::vector<nav::Goal> there_and_back(const sim::World& world) {
  if (!world.goal) throw InputError(fmt::format("world '{}': has no goal to walk to and from", world.name));
  return {{world.goal->position, world.goal->yaw}, {world.start.position(), world.start.yaw}};
}

void tell(std::size_t number, const Lap& lap) {
  constexpr double kMebibyte = 1 << 20;
  fmt::print(
      "{:4} {:9} {:8.1f} s  goal error {:.3f} m, map off {:.3f} m, heap {:.1f} MiB, {} descriptors{}{}\n",
      number, lap.outcome.end, lap.seconds, lap.outcome.goal_error, lap.outcome.map_error,
      static_cast<double>(lap.after.heap) / kMebibyte, lap.after.descriptors,
      lap.outcome.reason.empty() ? "" : ": ", lap.outcome.reason);
  std::fflush(stdout);
}

int run(const Options& options) {
  Robot robot = read_robot(options.robot);
  if (options.frame_rate > 0) robot.simulation.frame_rate = options.frame_rate;
  const sim::World world = read_world_for(robot, options.world);
  const std::vector<nav::Goal> goals = there_and_back(world);
  SimOptions sim;
  sim.range_mode = !options.stereo;
  sim.seed = options.seed ? options.seed : world.seed;
  sim.goal = goals.front();
  options.odometry.apply_to(sim);
  SimSession session(robot, world, sim);
  OutputFolder out(options.out, "patrol");
  std::size_t number = 0;
  const auto laps =
      patrol(session, goals, seconds(options.hours * 3600), [&](const Lap& lap) { tell(++number, lap); });
  const Endurance endurance = endurance_of(laps);
  out.report(patrol_report(laps, endurance));
  fmt::print(
      "{}: {} laps in {:.2f} simulated hours, heap {:+.2f} MiB, map {:+.3f} m, {} descriptors more; {}\n",
      world.name, endurance.laps, endurance.hours, endurance.heap_growth / (1 << 20), endurance.map_drift,
      endurance.descriptors_growth, out.list());
  for (const std::string& complaint : endurance.complaints()) fmt::print("  {}\n", complaint);
  return endurance.complaints().empty() ? kSuccess : kNotReached;
}

}  // namespace

void add_patrol(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "patrol", "Walk the simulated robot to and fro for hours: does anything grow, or drift?");
  command->add_option("world", options->world, "World file; between its start and its goal")->required();
  command->add_option("--out", options->out, kOutHelp)->required();
  command->add_option("--hours", options->hours, "Simulated")
      ->check(finite_in(0.01, 1000))
      ->capture_default_str();
  command->add_option("--frame-rate", options->frame_rate, "Of the cameras [Hz]; default: the robot file's")
      ->check(finite_in(1, 60));
  command->add_option("--seed", options->seed, "Seed of all noise; 0: the world's")
      ->check(seed_number())
      ->capture_default_str();
  options->odometry.add_to(*command);
  command->add_flag("--stereo", options->stereo, "With images and matcher, not in range mode");
  command->add_option("--robot", options->robot, "Robot file")->capture_default_str();
  command->footer(
      "Example: headway patrol config/worlds/lab.yaml --hours 8 --frame-rate 5 --out build/patrol\n"
      "Exit code 0 when every lap arrived and, from the second quarter of them to the last, neither the heap "
      "(1 MiB), nor open descriptors, nor the map's error (2 cm) grew.");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
