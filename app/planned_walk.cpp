#include "app/planned_walk.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/plot.h"
#include "hal/angle.h"

namespace headway::app {

namespace {

Json pose_row(const Pose2& pose) {
  return {rounded(pose.x), rounded(pose.y), rounded(pose.yaw / kDegree, 2)};
}

Json cost_row(const nav::PathCost& cost) {
  return {{"walking", rounded(cost.walking, 3)},
          {"turning", rounded(cost.turning, 3)},
          {"mode_changes", rounded(cost.mode_changes, 3)},
          {"nearness", rounded(cost.nearness, 3)},
          {"unseen", rounded(cost.unseen, 3)}};
}

Json path_rows(const nav::Path& path, const nav::FloorGrid& grid) {
  Json rows = Json::array();
  for (const nav::PathState& state : path.states) {
    const Eigen::Vector2d at = grid.centre(state.cell);
    rows.push_back({rounded(at.x()), rounded(at.y()), 45 * state.heading,
                    state.mode == nav::Mode::kForward ? "forward" : "sideway"});
  }
  return rows;
}

Json step_rows(const nav::Walk& walk) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < walk.steps.size(); ++i) {
    const hal::Footstep& step = walk.steps[i];
    rows.push_back({{"foot", step.foot == hal::Foot::kLeft ? "left" : "right"},
                    {"lands_at", pose_row(walk.stances[i].at(step.foot))},
                    {"seconds", rounded(to_seconds(step.duration), 3)}});
  }
  return rows;
}

}  // namespace

PlannedWalk plan_walk(const Robot& robot, const nav::FloorMap& floor, const Pose2& start,
                      const nav::Goal& goal) {
  const runtime::MissionConfig& mission = robot.mission;
  PlannedWalk out;
  out.start = start;
  out.goal = goal;
  out.plan =
      nav::Planner(mission.planner, mission.gait, mission.outline, floor.grid).plan(floor, start, goal);
  if (!out.plan) return out;
  const hal::Stance stance = hal::Stance::parallel(start, mission.gait.feet_apart);
  out.walk = nav::walk_along(mission.execution, out.plan.path, stance, std::nullopt, floor, mission.gait);
  const nav::WalkingConfig pattern = nav::walking_config(mission.gait);
  out.period = pattern.preview.period;
  nav::WalkForecaster forecaster(pattern, mission.gait.sole_length, mission.gait.sole_width);
  forecaster.rest_at(stance);
  out.forecast = forecaster.foresee(out.walk.steps, [&](const nav::WalkingSample& sample, double margin) {
    out.waist.push_back(sample.com);
    out.zmp.push_back(sample.zmp);
    out.margin.push_back(margin);
  });
  return out;
}

std::string complaint(const PlannedWalk& walk, const nav::GaitLimits& gait) {
  if (!walk.plan) {
    std::string why = fmt::format("no way to the goal: {}", nav::describe(walk.plan.reason));
    if (walk.plan.nearest)
      why += fmt::format("; the nearest place that can be reached is ({:.2f}, {:.2f})",
                         walk.plan.nearest->x(), walk.plan.nearest->y());
    return why;
  }
  return nav::complaint(walk.forecast, gait.zmp_margin);
}

Json report_of(const PlannedWalk& walk, const Robot& robot, const nav::FloorGrid& grid) {
  const std::string why = complaint(walk, robot.mission.gait);
  Json json = {{"robot", robot.name},
               {"from", pose_row(walk.start)},
               {"to", {rounded(walk.goal.position.x()), rounded(walk.goal.position.y())}},
               {"found", static_cast<bool>(walk.plan)},
               {"walkable", why.empty()},
               {"reason", why},
               {"expansions", walk.plan.expansions}};
  if (walk.goal.yaw) json["to"].push_back(rounded(*walk.goal.yaw / kDegree, 2));
  if (walk.plan.nearest) json["nearest"] = {rounded(walk.plan.nearest->x()), rounded(walk.plan.nearest->y())};
  if (!walk.plan) return json;
  const nav::Path& path = walk.plan.path;
  if (walk.plan.short_of_goal != nav::NoPath::kNone) {
    json["short_of_goal_m"] = rounded((path.end - walk.goal.position).norm());
    json["shortfall"] = nav::describe_shortfall(walk.plan, walk.goal);
  }
  json["end"] = {rounded(path.end.x()), rounded(path.end.y())};
  json["cost_s"] = rounded(path.cost_s, 3);
  json["cost"] = cost_row(path.cost);
  json["walk_s"] = rounded(static_cast<double>(walk.margin.size()) * walk.period, 3);
  if (walk.forecast) {
    const auto& step = walk.forecast->step;
    json["zmp"] = {{"margin_m", rounded(walk.forecast->margin)},
                   {"in_step", step ? Json(*step + 1) : Json()},  // null: while coming to rest
                   {"required_m", robot.mission.gait.zmp_margin}};
  }
  json["states"] = path_rows(path, grid);
  json["steps"] = step_rows(walk.walk);
  return json;
}

FloorLayers layers_of(const PlannedWalk& walk, const Robot& robot, const nav::FloorGrid& grid) {
  FloorLayers layers;
  layers.outline = robot.mission.outline;
  layers.gait = robot.mission.gait;
  layers.start = walk.start;
  layers.goal = walk.goal.position;
  layers.goal_yaw = walk.goal.yaw;
  if (!walk.plan) return layers;
  layers.path = polyline(walk.plan.path, grid);
  layers.bodies = walk.walk.bases;
  add_stance(hal::Stance::parallel(walk.start, robot.mission.gait.feet_apart), layers.feet);
  for (const FootPrint& foot : foot_prints(walk.walk)) layers.feet.push_back(foot);
  layers.waist = walk.waist;
  layers.zmp = walk.zmp;
  return layers;
}

cv::Mat zmp_picture(const PlannedWalk& walk, const nav::GaitLimits& gait) {
  const double end = static_cast<double>(walk.margin.size()) * walk.period;
  const double highest = *std::max_element(walk.margin.begin(), walk.margin.end());
  const double lowest = std::min(0.0, *std::min_element(walk.margin.begin(), walk.margin.end()));
  Plot plot(1000, 460, {0, end, "time [s]"}, {1e3 * lowest, 1.25e3 * highest, "ZMP inside the soles [mm]"},
            "How far the ZMP stays from the soles' edge");
  std::vector<Eigen::Vector2d> line;
  for (std::size_t i = 0; i < walk.margin.size(); ++i)
    line.emplace_back(static_cast<double>(i + 1) * walk.period, 1e3 * walk.margin[i]);
  plot.line(line, colours::kBlue, "by the walking pattern");
  plot.line({{0, 1e3 * gait.zmp_margin}, {end, 1e3 * gait.zmp_margin}}, colours::kVermilion,
            "required at least");
  return plot.finished();
}

}  // namespace headway::app
