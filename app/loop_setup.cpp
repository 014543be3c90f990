#include "app/loop_setup.h"

#include <cmath>

#include <fmt/format.h>

#include "app/world_map.h"
#include "hal/error.h"

namespace headway::app {

namespace {

LoopSetup common(const Robot& robot) {
  LoopSetup setup;
  setup.execution = robot.mission.execution == nav::Execution::kOrders ? "orders" : "steps";
  setup.matcher = vision::matcher_names()[static_cast<std::size_t>(robot.vision.matcher.kind)];
  setup.step_over = robot.mission.gait.over.height;
  setup.localise = robot.localisation.use;
  return setup;
}

Eigen::Vector3d point(const nlohmann::json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

}  // namespace

LoopSetup loop_setup(const Robot& robot, const sim::World& world, const SimOptions& options) {
  LoopSetup setup = common(robot);
  const nav::VoxelMapConfig box = map_box(robot, world);
  setup.range_mode = options.range_mode;
  setup.start = world.start;
  setup.lowest = box.lowest;
  setup.highest = box.highest;
  setup.frame_rate = robot.simulation.frame_rate;
  setup.replan = options.replan;
  setup.localise &= options.localise;
  setup.seed = options.seed;
  return setup;
}

LoopSetup loop_setup(const Robot& robot, const LiveOptions& options) {
  LoopSetup setup = common(robot);
  const Eigen::Vector2d half = options.floor / 2, at = options.start.position();
  const double margin = robot.map_margin;
  setup.start = options.start;
  setup.lowest = {at.x() - half.x() - margin, at.y() - half.y() - margin, robot.map_height.x()};
  setup.highest = {at.x() + half.x() + margin, at.y() + half.y() + margin, robot.map_height.y()};
  setup.frame_rate = options.frame_rate;
  return setup;
}

Robot with(const LoopSetup& setup, Robot robot) {
  robot.mission.execution = setup.execution == "orders" ? nav::Execution::kOrders : nav::Execution::kSteps;
  robot.vision.matcher.kind = vision::matcher_kind(setup.matcher);
  step_over(setup.step_over, robot);
  robot.mission.replan = setup.replan;
  robot.localisation.use = setup.localise;
  if (setup.range_mode) {  // eyes without a matcher err otherwise
    robot.localisation.localise.shift_sigma = robot.simulation.depth_shift_sigma;
    robot.localisation.localise.turn_sigma = robot.simulation.depth_turn_sigma;
  }
  robot.mapper.voxels.lowest = setup.lowest;
  robot.mapper.voxels.highest = setup.highest;
  robot.mapper.voxels.validate();
  return robot;
}

Json to_json(const LoopSetup& s) {
  return {{"range_mode", s.range_mode},
          {"start", {s.start.x, s.start.y, s.start.yaw}},
          {"lowest", {s.lowest.x(), s.lowest.y(), s.lowest.z()}},
          {"highest", {s.highest.x(), s.highest.y(), s.highest.z()}},
          {"frame_rate", s.frame_rate},
          {"execution", s.execution},
          {"matcher", s.matcher},
          {"step_over", s.step_over},
          {"replan", s.replan},
          {"localise", s.localise},
          {"seed", s.seed}};
}

LoopSetup loop_setup_from(const std::string& text) {
  LoopSetup s;
  try {
    const auto json = nlohmann::json::parse(text);
    const Eigen::Vector3d start = point(json.at("start"));
    s.range_mode = json.at("range_mode");
    s.start = {start.x(), start.y(), start.z()};
    s.lowest = point(json.at("lowest"));
    s.highest = point(json.at("highest"));
    s.frame_rate = json.at("frame_rate");
    s.execution = json.at("execution");
    s.matcher = json.at("matcher");
    s.step_over = json.at("step_over");
    s.replan = json.at("replan");
    s.localise = json.at("localise");
    s.seed = json.at("seed");
  } catch (const nlohmann::json::exception& fault) {
    throw InputError(fmt::format("the set-up of the loops is not as expected: {}", fault.what()));
  }
  if (!s.lowest.allFinite() || !s.highest.allFinite() || !(s.frame_rate > 0))
    throw InputError("the set-up of the loops has numbers that cannot be");
  return s;
}

}  // namespace headway::app
