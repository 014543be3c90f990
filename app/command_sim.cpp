#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/finite_range.h"
#include "app/interrupts.h"
#include "app/map_file.h"
#include "app/odometry_options.h"
#include "app/operator_page.h"
#include "app/pace.h"
#include "app/recording_folder.h"
#include "app/recording_preface.h"
#include "app/report.h"
#include "app/sim_outputs.h"
#include "app/sim_session.h"
#include "app/world_map.h"
#include "hal/clock.h"
#include "hal/error.h"
#include "runtime/recorder.h"
#include "sim_hal/fault_file.h"

namespace headway::app {

namespace {

struct Options {
  std::filesystem::path world, map, faults, out, record, robot = default_robot_file();
  std::vector<double> goal;
  std::string matcher, execution;
  std::optional<double> step_over;
  std::uint64_t seed = 0;
  bool near = false, no_replan = false, range = false, exact_feet = false;
  double longest = 400;
  OdometryOptions odometry;
  std::optional<double> tilt_error, frame_rate;
  ServeOptions page;
};

void print_memory(const runtime::Mapper& mapper) {
  const auto mebibytes = [](std::size_t bytes) { return static_cast<double>(bytes) / (1 << 20); };
  const Eigen::Vector3d window = mapper.voxels().highest() - mapper.voxels().lowest();
  fmt::print("map: a window of {:.1f} x {:.1f} x {:.1f} m in {:.1f} MiB, {} bricks aside in {:.1f} MiB\n",
             window.x(), window.y(), window.z(), mebibytes(mapper.voxels().bytes()), mapper.aside().size(),
             mebibytes(mapper.aside().bytes()));
}

/// The next run into a folder removes the files of the one before.
void require_outside(const std::filesystem::path& map, const std::filesystem::path& out) {
  std::error_code none;
  const auto folder = std::filesystem::weakly_canonical(map, none).parent_path();
  if (folder == std::filesystem::weakly_canonical(out / "x", none).parent_path())
    throw InputError(
        fmt::format("--map: {} lies in the folder that --out names, whose files are removed first; "
                    "expected another folder",
                    map.string()));
}

void set_up_in(const std::filesystem::path& file, const nav::SavedMap& known, SimSession& session) {
  try {
    session.restore(known);
  } catch (const InputError& fault) {
    throw InputError(fmt::format("{}: {}", file.string(), fault.what()));
  }
  if (known.surfaces.voxels() == 0)
    fmt::print("{}: has no surfaces to align views with; the robot is taken to stand just where it began\n",
               file.string());
}

/// What could not be recorded is an error where a recording was asked for at the start.
void tell_of(runtime::Recorder& recorder, bool asked_for) {
  std::string fault;
  if (asked_for && recorder.news(fault)) throw Error(fault);
  while (recorder.news(fault)) fmt::print("{}\n", fault);
  if (!recorder.tape()) return;
  fmt::print("{}: {:.1f} MiB\n", recorder.tape()->file().string(),
             static_cast<double>(recorder.tape()->bytes()) / (1 << 20));
}

/// By the clock of the wall, with the page served, until somebody ends it.
SimOutcome run_served(SimSession& session, const ServeOptions& options, runtime::Recorder& recorder,
                      const std::filesystem::path& recordings) {
  Interrupts interrupts;
  hal::MonotonicClock clock;
  OperatorPage page(options, session.robot(), session.mapper().floor().grid, session.scene().world().start,
                    session.line(), clock);
  page.offer_recording(recorder, recordings);
  session.observe([&](const runtime::FrameSnapshot& snapshot) { page.see(snapshot); });
  fmt::print("{}\nCtrl-C ends it\n", page.address());
  std::fflush(stdout);
  OperatorPage::Beside beside;
  beside.simulated = true;
  Pace pace(clock);
  return session.run_while([&] {
    beside.bus_cycles = session.bus_loop().counters().cycles;
    beside.speed = pace.keep(session.now());
    page.serve(session.status(), beside, session.now());
    return !interrupts.asked();
  });
}

int run(const Options& options) {
  Robot robot = read_robot(options.robot);
  if (options.execution == "orders") robot.mission.execution = nav::Execution::kOrders;
  if (options.execution == "steps") robot.mission.execution = nav::Execution::kSteps;
  step_over(options.step_over.value_or(robot.mission.gait.over.height), robot);
  if (!options.matcher.empty()) robot.vision.matcher.kind = vision::matcher_kind(options.matcher);
  if (options.frame_rate) robot.simulation.frame_rate = *options.frame_rate;
  const sim::World world = read_world_for(robot, options.world);
  SimOptions sim;
  sim.range_mode = options.range;
  sim.replan = !options.no_replan;
  sim.exact_feet = options.exact_feet;
  options.odometry.apply_to(sim);
  if (options.tilt_error) sim.tilt_error = *options.tilt_error * std::numbers::pi / 180;
  sim.seed = options.seed ? options.seed : world.seed;
  sim.longest = seconds(options.longest);
  sim.near = options.near;
  sim.waits = options.page.serve;
  if (!options.faults.empty()) sim.faults = sim::read_faults(options.faults);
  if (!options.goal.empty()) {
    sim.goal.emplace();
    sim.goal->position = {options.goal[0], options.goal[1]};
    if (options.goal.size() == 3) sim.goal->yaw = options.goal[2] * std::numbers::pi / 180;
  }
  if (!options.map.empty()) require_outside(options.map, options.out);
  std::optional<nav::SavedMap> known;
  if (!options.map.empty()) known = read_saved(options.map);
  hal::MonotonicClock clock;
  std::unique_ptr<runtime::Recorder> recorder;
  const std::filesystem::path recordings = recording_folder(options.record);
  if (!options.record.empty() || options.page.serve) {
    runtime::Preface preface = recording_preface(robot, loop_setup(robot, world, sim), "sim");
    if (known) known = keep_known_map(*known, preface);
    runtime::RecorderConfig config;
    config.files.emplace().folder = recordings;
    config.record_at_once = !options.record.empty();
    recorder = std::make_unique<runtime::Recorder>(config, preface, clock, Time{});
    sim.recorder = recorder.get();
  }
  SimSession session(robot, world, sim);
  if (known) set_up_in(options.map, *known, session);
  OutputFolder out(options.out, "sim", SimOutputs::kNames);
  SimOutputs outputs(session);
  Progress progress(world.name);
  session.on_progress([&] {
    const Pose2 base = session.body().stance().base();
    progress.show(static_cast<std::size_t>(to_seconds(session.now())),
                  static_cast<std::size_t>(options.longest),
                  fmt::format("s  {}  {:.2f} m to go", name(session.mission().state()),
                              (base.position() - session.goal().position).norm()));
  });
  const SimOutcome outcome =
      options.page.serve ? run_served(session, options.page, *recorder, recordings) : session.run();
  if (recorder) recorder->stop();
  outputs.write(outcome, out);
  fmt::print("{}\n", out.list());
  const auto& counts = session.mission().counters();
  fmt::print("{}: {}{}{}; {:.2f} m in {:.1f} s, {} steps, {} replans, goal error {:.3f} m\n", world.name,
             outcome.end, outcome.reason.empty() ? "" : ": ", outcome.reason, outcome.walked, outcome.seconds,
             session.steps().size(), counts.replans, outcome.goal_error);
  if (!options.near && outcome.reason.starts_with("no way"))
    fmt::print("with --near the robot walks to the reachable place nearest to the goal\n");
  if (!sim.faults.empty()) fmt::print("{}", fault_lines(session.faults()));
  print_memory(session.mapper());
  fmt::print("{}", walk_cost_table(outputs.walk_cost().stretches()));
  if (recorder) tell_of(*recorder, !options.record.empty());
  return outcome.arrived || outcome.end == "ended" ? kSuccess : kNotReached;
}

}  // namespace

void add_sim(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "sim", "Run the whole program on a simulated robot: look around, map, plan, walk, replan, arrive");
  command->add_option("world", options->world, "World file, e.g. config/worlds/lab.yaml")->required();
  command->add_option("--out", options->out, kOutHelp)->required();
  command->add_option("--goal", options->goal, "Where to go [m, deg]; default: the world's goal")
      ->delimiter(',')
      ->expected(2, 3)
      ->option_text("X,Y[,YAW]")
      ->check(finite_in(-500, 500));
  command->add_option(
      "--map", options->map,
      "What the robot knows already: a map that an earlier run saved (.hmap, or .bt, .ot). It "
      "finds its place there, and steps nowhere before it has looked again");
  command->add_option(
      "--record", options->record,
      "Folder for a recording (.mcap) of all that happens, for 'headway replay'. With --serve "
      "the page begins and ends recordings too, without it with the user's state");
  command->add_flag("--near", options->near,
                    "Where no way leads to the goal, walk to the reachable place nearest to it");
  command
      ->add_option(
          "--execution", options->execution,
          "How the way is told to the control computer: each footstep (steps), or whole motions whose "
          "feet it places itself (orders); default: the robot's")
      ->check(CLI::IsMember({"steps", "orders"}))
      ->type_name("NAME");
  command
      ->add_option("--step-over", options->step_over,
                   "Step over what rises no more than that [m]; default: the robot file's gait.step_over")
      ->check(finite_in(0, 0.14));
  command->add_option("--robot", options->robot, "Robot file")->capture_default_str();
  command->add_option("--seed", options->seed, "Seed of all noise; 0: the world's")
      ->check(seed_number())
      ->capture_default_str();
  command->add_flag("--no-replan", options->no_replan, "Follow the first plan, whatever is seen later");
  options->odometry.add_to(*command);
  command->add_flag("--exact-feet", options->exact_feet, "Feet land exactly where they should");
  command
      ->add_option("--tilt-error", options->tilt_error,
                   "Degrees by which the head truly looks lower than its drive reports")
      ->check(finite_in(-5, 5));
  command->add_flag("--range", options->range,
                    "Depth straight from the ray caster, without images and matcher (fast)");
  command->add_option("--faults", options->faults,
                      "What goes wrong on the way: a fault plan, e.g. config/faults/three.yaml");
  command->add_option("--frame-rate", options->frame_rate, "Of the cameras [Hz]; default: the robot file's")
      ->check(finite_in(1, 60));
  command->add_option("--matcher", options->matcher, "census, sgbm or bm; default: the robot's")
      ->check(CLI::IsMember(vision::matcher_names()))
      ->type_name("NAME")
      ->excludes("--range");
  add_serve_options(*command, options->page);
  command->add_option("--longest", options->longest, "Give up after so many simulated seconds")
      ->check(finite_in(1, 36000))
      ->capture_default_str();
  command->footer(
      "Example: headway sim config/worlds/moving_box.yaml --out build/demo\n"
      "Writes report.json, timing.json, map.hmap, map.bt, floor.pgm, floor.yaml, cloud.ply and pictures:\n"
      "scene, views, left, depth, uncertainty and plan as the walk begins, replan and replan_left, and\n"
      "floor and map (all that was ever seen) at its end.\n"
      "Exit code 0 when the robot arrived (with --near also as near as it gets, which report.json says), 1 "
      "when it did not (report.json says why).");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
