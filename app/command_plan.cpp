// headway plan: a floor map, a start and a goal; the way, the steps, and whether they can be walked.
#include <memory>
#include <ostream>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/finite_range.h"
#include "app/floor_source.h"
#include "app/floor_svg.h"
#include "app/output_folder.h"
#include "app/planned_walk.h"
#include "hal/angle.h"
#include "nav/whole_file.h"

namespace headway::app {

namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path map, out, robot = default_robot_file();
  std::vector<double> from, to;
  std::string unseen;
  double cell = 0.05;
  bool near = false;
};

void choose_unseen(const std::string& how, nav::PlannerConfig& planner) {
  if (how == "blocked") planner.unseen = nav::UnseenFloor::kBlocked;
  if (how == "costly") planner.unseen = nav::UnseenFloor::kCostly;
  if (how == "free") planner.unseen = nav::UnseenFloor::kFree;
}

int run(const Options& options) {
  Robot robot = read_robot(options.robot);
  choose_unseen(options.unseen, robot.mission.planner);
  const Pose2 start{options.from[0], options.from[1],
                    options.from.size() > 2 ? wrap_angle(options.from[2] * kDegree) : 0};
  nav::Goal goal{{options.to[0], options.to[1]}, std::nullopt};
  goal.near = options.near;
  if (options.to.size() > 2) goal.yaw = wrap_angle(options.to[2] * kDegree);
  const nav::FloorMap floor = read_floor(options.map, robot, {"--from", start}, options.cell);
  require_inside(area_of(floor.grid), {"--to", {goal.position.x(), goal.position.y(), 0}});

  OutputFolder out(options.out, "plan");
  Stopwatch watch;
  const PlannedWalk walk = plan_walk(robot, floor, start, goal);
  const double ms = watch.lap_ms();
  const FloorLayers layers = layers_of(walk, robot, floor.grid);
  write_png(floor_picture(floor, layers), out.file("plan.png"));
  nav::write_whole(out.file("plan.svg"), [&](std::ostream& to) {
    to << floor_svg(floor, layers, options.map.filename().string());
  });
  if (!walk.margin.empty()) write_png(zmp_picture(walk, robot.mission.gait), out.file("zmp.png"));
  Json report = report_of(walk, robot, floor.grid);
  report["map"] = options.map.string();
  out.report(report);
  fmt::print("{}\n", out.list());
  if (const std::string why = complaint(walk, robot.mission.gait); !why.empty()) {
    fmt::print("{}\n", why);
    if (!walk.plan && !goal.near)
      fmt::print("with --near the way leads to the reachable place nearest to the goal\n");
    return kNotReached;
  }
  if (const std::string shortfall = nav::describe_shortfall(walk.plan, goal); !shortfall.empty())
    fmt::print("{}\n", shortfall);
  fmt::print("{} steps, {:.1f} s of walking; planned in {:.1f} ms\n", walk.walk.steps.size(),
             static_cast<double>(walk.margin.size()) * walk.period, ms);
  return kSuccess;
}

}  // namespace

void add_plan(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("plan", "The way on a saved map, its steps, and whether they can be walked");
  command
      ->add_option(
          "map", options->map,
          "Floor map (map_server's .yaml, Moving AI's .map) or voxel map (.hmap, .bt, .ot) with its floor "
          "at z = 0")
      ->required()
      ->type_name("FILE");
  const auto place = [&](const char* name, std::vector<double>& value, const char* help) {
    command->add_option(name, value, help)
        ->required()
        ->delimiter(',')
        ->expected(2, 3)
        ->option_text("X,Y[,YAW] REQUIRED")
        ->check(finite_in(-100000, 100000));
  };
  place("--from", options->from, "Where the robot stands [m, deg]");
  place("--to", options->to, "Where it is to go [m, deg]; without YAW it may face anywhere");
  command->add_flag(
      "--near", options->near,
      "Where no way leads there, go to the reachable place nearest to it (straight over the floor)");
  command->add_option("--out", options->out, kOutHelp)->required()->type_name("DIR");
  command->add_option("--robot", options->robot, "Robot file")->type_name("FILE")->capture_default_str();
  command->add_option("--unseen", options->unseen, "What floor is that nobody has seen; default: the robot's")
      ->check(CLI::IsMember({"blocked", "costly", "free"}))
      ->type_name("NAME");
  command->add_option("--cell", options->cell, "Width of a cell of a Moving AI map [m]")
      ->check(finite_in(0.01, 1))
      ->capture_default_str();
  command->footer(
      "Writes report.json (path, steps, costs in seconds of walking, the ZMP's margin), plan.png and "
      "plan.svg (path,\n"
      "body masks, feet, waist and ZMP) and zmp.png.\n"
      "Example: headway plan build/demo/floor.yaml --from 0,0 --to 3,1,90 --out build/plan\n"
      "Exit code 0 when the way can be walked, 1 when there is none or its steps would tip the robot "
      "(report.json\n"
      "says why).");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
