// headway next-view: a saved map and a robot in it; where it should look next, and what that would show.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/finite_range.h"
#include "app/floor_source.h"
#include "app/map_view.h"
#include "app/output_folder.h"
#include "app/pictures.h"
#include "app/plot.h"
#include "app/report.h"
#include "app/robot_file.h"
#include "hal/angle.h"
#include "hal/error.h"
#include "nav/explored.h"
#include "nav/next_view.h"

namespace headway::app {

namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path map, out, robot = default_robot_file();
  std::vector<double> at{0, 0, 0}, head{0, 0};
  std::size_t most = 5;
  double least_gain = 0;  // 0: the robot's
  bool stay = false;
};

/// What is asked, and the answer.
struct Question {
  Robot robot;
  nav::VoxelMap map;
  nav::FloorMap floor;
  Pose2 base;
  hal::HeadAngles head;
  std::vector<nav::NextLook> turns, walks;
  std::optional<nav::Path> way;  ///< to the best stance
};

nav::NextViewConfig config_of(const Robot& robot, const Options& options) {
  nav::NextViewConfig config = robot.mission.next_view.value_or(nav::NextViewConfig{});
  if (options.least_gain > 0) config.least_gain = options.least_gain;
  return config;
}

/// Throws InputError where the head does not turn so far.
hal::HeadAngles head_of(const Options& options, const hal::HeadLimits& limits) {
  constexpr double kRounded = 1e-3;  // [deg]; limits are often no whole degrees
  const Eigen::Array2d lower = Eigen::Array2d(limits.lower.pan, limits.lower.tilt) / kDegree,
                       upper = Eigen::Array2d(limits.upper.pan, limits.upper.tilt) / kDegree,
                       asked(options.head[0], options.head[1]);
  if ((asked < lower - kRounded).any() || (asked > upper + kRounded).any())
    throw InputError(fmt::format(
        "--head: ({:g}, {:g}) is more than the head turns, expected pan from {:.4g} to {:.4g} and "
        "tilt from {:.4g} to {:.4g} deg",
        asked[0], asked[1], lower[0], upper[0], lower[1], upper[1]));
  return runtime::limited({asked[0] * kDegree, asked[1] * kDegree}, limits);
}

Question ask(const Options& options) {
  Robot robot = read_robot(options.robot);
  const Pose2 base{options.at[0], options.at[1], options.at.size() > 2 ? options.at[2] * kDegree : 0};
  const hal::HeadAngles head = head_of(options, robot.mission.head);
  nav::VoxelMap map = read_map_around(options.map, robot, {"--at", base});
  nav::FloorMap floor = nav::floor_map(map, robot.mapper.floor);
  require_standing(floor, robot.mission.outline, {"--at", base});
  Question q{std::move(robot), std::move(map), std::move(floor), base, head, {}, {}, {}};
  nav::start_clear(q.floor, q.base, q.robot.mapper.start_area, Time{});
  const runtime::MissionConfig& mission = q.robot.mission;
  nav::NextView next({mission.field, mission.neck, mission.head, q.robot.chest_height}, q.map.resolution(),
                     config_of(q.robot, options));
  q.turns = next.turns(q.map, q.base.lifted(q.robot.chest_height), q.head);
  if (options.stay) return q;
  nav::Planner planner(mission.planner, mission.gait, mission.outline, q.floor.grid);
  q.walks = next.walks(q.map, q.floor, planner, mission.gait, q.base, options.most);
  if (q.walks.empty()) return q;
  const Pose2& stance = *q.walks.front().stance;
  nav::PlanResult way = planner.plan(q.floor, q.base, {stance.position(), stance.yaw, 0});
  if (way && way.path.states.size() > 1) q.way = std::move(way.path);
  return q;
}

/// Both kinds together, the best first.
std::vector<nav::NextLook> best(const Question& q, std::size_t most) {
  std::vector<nav::NextLook> all = q.turns;
  all.insert(all.end(), q.walks.begin(), q.walks.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const nav::NextLook& a, const nav::NextLook& b) { return a.rate() > b.rate(); });
  all.resize(std::min(all.size(), most));
  return all;
}

Json row(const nav::NextLook& look) {
  Json json = {{"how", look.stance ? "walk" : "turn"},
               {"pan_deg", rounded(look.head.pan / kDegree, 2)},
               {"tilt_deg", rounded(look.head.tilt / kDegree, 2)}};
  if (look.stance)
    json.update({{"x", rounded(look.stance->x, 3)},
                 {"y", rounded(look.stance->y, 3)},
                 {"yaw_deg", rounded(look.stance->yaw / kDegree, 1)}});
  json.update({{"gain_m3", rounded(look.gain)},
               {"seconds", rounded(look.seconds, 3)},
               {"gain_m3_per_s", rounded(look.rate())}});
  return json;
}

std::string line(const nav::NextLook& look) {
  const std::string head =
      fmt::format("pan {:4.0f}, tilt {:3.0f} deg", look.head.pan / kDegree, look.head.tilt / kDegree);
  const std::string where = look.stance
                                ? fmt::format("walk to ({:.2f}, {:.2f}, {:.0f} deg), ", look.stance->x,
                                              look.stance->y, look.stance->yaw / kDegree)
                                : std::string("turn the head: ");
  return fmt::format("{}{}: {:.2f} m3 in {:.1f} s", where, head, look.gain, look.seconds);
}

Json report(const Question& q, const Options& options) {
  const nav::ExploredSpace space = nav::explored(q.map);
  Json json = {{"map", options.map.string()},
               {"robot", q.robot.name},
               {"at", {rounded(q.base.x), rounded(q.base.y), rounded(q.base.yaw / kDegree, 2)}},
               {"head_deg", {rounded(q.head.pan / kDegree, 2), rounded(q.head.tilt / kDegree, 2)}},
               {"least_gain_m3", config_of(q.robot, options).least_gain},
               {"unseen_m3", rounded(space.unseen, 3)},
               {"best", Json::array()},
               {"turns", Json::array()},
               {"walks", Json::array()}};
  for (const nav::NextLook& look : best(q, options.most)) json["best"].push_back(row(look));
  for (const nav::NextLook& look : q.turns) json["turns"].push_back(row(look));
  for (const nav::NextLook& look : q.walks) json["walks"].push_back(row(look));
  return json;
}

/// The map with its unseen space, and the robot in it.
cv::Mat space_picture(const Question& q) {
  MapViewConfig config;
  config.width = 760;
  config.height = 700;
  config.highest.z() = 1.7;
  config.show_unseen = true;
  MapFigures figures;
  figures.robot = q.base;
  if (!q.walks.empty()) figures.goal = q.walks.front().stance->position();
  if (q.way) figures.path = polyline(*q.way, q.floor.grid);
  return map_view(q.map, bird_view(q.map, config, -2.3, 0.75, figures), config, figures);
}

/// The floor around the robot and its stances: of a large map the rest would make them too small to be seen.
nav::FloorMap floor_nearby(const Question& q) {
  constexpr double kMargin = 3;  // [m]
  Eigen::AlignedBox2d nearby(q.base.position());
  for (const nav::NextLook& look : q.walks) nearby.extend(look.stance->position());
  const nav::FloorGrid& grid = q.floor.grid;
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kMargin);
  const Eigen::Vector2i first = grid.cell(nearby.min() - margin).cwiseMax(0),
                        last =
                            grid.cell(nearby.max() + margin)
                                .cwiseMin(Eigen::Vector2i(grid.width, grid.height) - Eigen::Vector2i::Ones()),
                        size = last - first + Eigen::Vector2i::Ones();
  nav::FloorMap part = nav::unseen_floor(
      {grid.resolution, grid.origin + grid.resolution * first.cast<double>(), size.x(), size.y()});
  for (int y = 0; y < size.y(); ++y)
    for (int x = 0; x < size.x(); ++x)
      part.cells[part.grid.index({x, y})] = q.floor.at(first + Eigen::Vector2i(x, y));
  return part;
}

cv::Mat walk_picture(const Question& q) {
  FloorLayers layers;
  layers.outline = q.robot.mission.outline;
  layers.gait = q.robot.mission.gait;
  layers.robot = q.base;
  for (const nav::NextLook& look : q.walks) layers.bodies.push_back(*look.stance);
  layers.goal_label = "the best stance";
  if (!q.walks.empty()) {
    layers.goal = q.walks.front().stance->position();
    layers.goal_yaw = q.walks.front().stance->yaw;
  }
  if (q.way) layers.path = polyline(*q.way, q.floor.grid);
  return floor_picture(floor_nearby(q), layers);
}

/// Directions of the head as the robot sees them: left is left, up is up; coloured by what they would show.
cv::Mat turn_picture(const Question& q) {
  const runtime::MissionConfig& mission = q.robot.mission;
  const nav::NextView next({mission.field, mission.neck, mission.head, q.robot.chest_height},
                           q.map.resolution());
  // Half of what lies between neighbours, and room for the legend above.
  const hal::HeadAngles first = next.directions().front(), last = next.directions().back();
  const auto tilts = std::count_if(next.directions().begin(), next.directions().end(),
                                   [&](const hal::HeadAngles& d) { return d.pan == first.pan; });
  const auto pans = static_cast<std::ptrdiff_t>(next.directions().size()) / tilts;
  const Eigen::Vector2d half(0.5 * (last.pan - first.pan) / static_cast<double>(pans - 1) / kDegree,
                             0.5 * (last.tilt - first.tilt) / static_cast<double>(tilts - 1) / kDegree);
  const PlotAxis pan{last.pan / kDegree + half.x(), first.pan / kDegree - half.x(),
                     "pan [deg], to the left positive"};
  const PlotAxis tilt{last.tilt / kDegree + half.y(), first.tilt / kDegree - 2.6 * half.y(),
                      "tilt [deg], down positive"};
  double most = 0.1;
  for (const nav::NextLook& look : q.turns) most = std::max(most, look.gain);
  Plot plot(620, 560, pan, tilt, "");
  const auto at = [](const hal::HeadAngles& a) -> Eigen::Vector2d {
    return Eigen::Vector2d(a.pan, a.tilt) / kDegree;
  };
  const Eigen::Vector2d reach = 0.94 * half;
  for (const hal::HeadAngles& d : next.directions()) plot.cell(at(d) - reach, at(d) + reach, colours::kPale);
  for (std::size_t i = 0; i < q.turns.size(); ++i) {
    const nav::NextLook& look = q.turns[i];
    const Colour colour = ramp_colour(Ramp::kViridis, look.gain / most);
    plot.cell(at(look.head) - reach, at(look.head) + reach, colour);
    plot.note(at(look.head), fmt::format("{:.2f}", look.rate()),
              look.gain > 0.5 * most ? colours::kInk : colours::kPaper);
  }
  plot.dots({at(q.head)}, colours::kVermilion, "the head now");
  if (!q.turns.empty()) {
    const Eigen::Vector2d c = at(q.turns.front().head);
    plot.outline({c - reach, c + Eigen::Vector2d(reach.x(), -reach.y()), c + reach,
                  c + Eigen::Vector2d(-reach.x(), reach.y())},
                 colours::kVermilion, 3);
    plot.key({colours::kVermilion, "the best turn", Key::Shape::kFrame});
  }
  plot.key({colours::kPale, "nothing worth it", Key::Shape::kPatch});
  return with_legend(plot.finished(),
                     "unseen space that each direction shows at most [m3]; numbers: per second",
                     Ramp::kViridis, linear_ticks(0, most));
}

int run(const Options& options) {
  const Question q = ask(options);
  OutputFolder out(options.out, "next-view");
  write_png(strip({{space_picture(q), "what is known; violet: where it borders on unseen space"},
                   {turn_picture(q), "turning the head"},
                   {walk_picture(q), "walking first: the best stances"}}),
            out.file("next_view.png"));
  out.report(report(q, options));
  const auto looks = best(q, options.most);
  for (const nav::NextLook& look : looks) fmt::print("{}\n", line(look));
  fmt::print("{}; {}\n", out.list(),
             looks.empty()
                 ? "nothing is left to gain"
                 : fmt::format("{} turns and {} walks are worth it", q.turns.size(), q.walks.size()));
  return looks.empty() ? kNotReached : kSuccess;
}

}  // namespace

void add_next_view(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("next-view", "Where a robot should look next, by a saved map");
  command
      ->add_option("map", options->map,
                   "Map as `sim`, `map` and `map convert` write it: Headway's .hmap or OctoMap's .bt or .ot, "
                   "its floor at z = 0")
      ->required()
      ->type_name("FILE");
  command->add_option("--out", options->out, kOutHelp)->required()->type_name("DIR");
  command->add_option("--at", options->at, "Where the robot stands [m, deg]")
      ->delimiter(',')
      ->expected(2, 3)
      ->check(finite_in(-2000, 2000))
      ->option_text(fmt::format("X,Y[,YAW]={}", fmt::join(options->at, ",")));
  command->add_option("--head", options->head, "Where the head looks now [deg]; left and down are positive")
      ->delimiter(',')
      ->expected(2)
      ->check(finite_in(-180, 180))
      ->option_text(fmt::format("PAN,TILT={}", fmt::join(options->head, ",")));
  command->add_option("--robot", options->robot, "Robot file")->type_name("FILE")->capture_default_str();
  command->add_option("--most", options->most, "So many looks are printed, and so many walks worked out")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      ->add_option("--least-gain", options->least_gain,
                   "Looks that show less are not worth it [m3]; default: the robot's")
      ->check(finite_in(1e-6, 1000));
  command->add_flag("--stay", options->stay, "Turn the head only, do not walk");
  command->footer(
      "The gain of a look is the space that it would show for the first time: unseen voxels from the floor "
      "to the\n"
      "body's height, inside the rig's field, before the first obstacle. Unseen space hides nothing, so that "
      "is the\n"
      "most it can show. The cost is the time for turning the head, or for walking to free floor and looking "
      "straight\n"
      "ahead there. The best look is the one with the most gain per second.\n"
      "Writes report.json and next_view.png.\n"
      "Example: headway next-view build/demo/map.bt --at -2.2,0 --out build/next\n"
      "Exit code 0 when a look is worth it, 1 when nothing is left to gain.");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
