#include "app/live_control.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "app/frames_report.h"
#include "app/safety_report.h"
#include "config/yaml_limits.h"
#include "hal/error.h"

namespace headway::app {

namespace {

constexpr double kFarthest = 500;  // of a goal, along each axis [m]

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

double milliseconds(Duration time) { return to_seconds(time) * 1000; }

Json goal_json(const LiveStatus& status) {
  if (!status.goal) return nullptr;
  Json goal{{"x", rounded(status.goal->position.x())}, {"y", rounded(status.goal->position.y())}};
  if (status.goal->yaw) goal["yaw_deg"] = rounded(degrees(*status.goal->yaw), 1);
  goal["near"] = status.goal->near;
  goal["short_of_goal_m"] = rounded(status.short_of_goal);
  return goal;
}

/// In microseconds.
Json bus_loop_json(const runtime::LiveLoops& loops) {
  const auto us = [](Duration time) { return rounded(1e6 * to_seconds(time), 1); };
  const runtime::LoopFigures figures = loops.figures();
  return {{"health", name(loops.bus_health())},
          {"rounds", figures.bus_wake_up.count},
          {"missed", figures.missed},
          {"wake_p99_us", us(figures.bus_wake_up.p99)},
          {"wake_max_us", us(figures.bus_wake_up.max)},
          {"run_p99_us", us(figures.bus_run.p99)},
          {"run_max_us", us(figures.bus_run.max)}};
}

/// A finite number within kFarthest of 0; throws InputError naming `key` otherwise.
double number(const Json& value, const char* key, double most) {
  if (!value.is_number() || !(std::abs(value.get<double>()) <= most))
    throw InputError(fmt::format("{}: expected a number from {:g} to {:g}", key, -most, most));
  return value.get<double>();
}

bool flag(const Json& question, const char* key) {
  const auto found = question.find(key);
  if (found == question.end()) return false;
  if (!found->is_boolean()) throw InputError(fmt::format("{}: expected true or false", key));
  return found->get<bool>();
}

/// From where the coordinates count.
Pose2 origin(const Json& question, const LiveStatus& status) {
  const auto from = question.find("from");
  if (from == question.end() || *from == "robot") return status.base;
  if (*from == "map") return {};
  throw InputError("from: expected \"robot\" or \"map\"");
}

nav::Goal goal_from(const Json& question, const LiveStatus& status) {
  const auto to = question.find("to");
  if (to == question.end() || !to->is_array() || to->size() != 2)
    throw InputError("to: expected two numbers, [x, y] in metres");
  const Pose2 seen_from = origin(question, status);
  nav::Goal goal;
  goal.position = seen_from * Eigen::Vector2d(number(to->at(0), "to[0]", kFarthest),
                                              number(to->at(1), "to[1]", kFarthest));
  if (const auto yaw = question.find("yaw_deg"); yaw != question.end())
    goal.yaw = wrap_angle(seen_from.yaw + number(*yaw, "yaw_deg", 360) * std::numbers::pi / 180);
  goal.near = flag(question, "near");
  return goal;
}

Json do_what(const Json& question, LiveSession& session, const LiveStatus& status, Time now) {
  if (!question.is_object()) throw InputError("expected an object, such as {\"do\": \"status\"}");
  const auto what = question.find("do");
  if (what != question.end() && *what == "status") return status_json(session, status, now);
  if (what != question.end() && *what == "go") {
    if (status.stamp == Time{}) throw InputError("go: it is not known yet where the robot stands; ask again");
    const nav::Goal goal = goal_from(question, status);
    session.go(goal);
    return {{"x", rounded(goal.position.x())}, {"y", rounded(goal.position.y())}};
  }
  if (what != question.end() && *what == "stay") {
    session.stay();
    if (const auto hangs = session.hanging(now))
      throw Error(*hangs + "; it may not hear this: use the button");
    return Json::object();
  }
  if (what != question.end() && *what == "reset") {
    session.reset();
    return Json::object();
  }
  throw InputError("do: expected \"status\", \"go\", \"stay\" or \"reset\"");
}

std::string metric(const char* name, const char* type, const char* help, const Json& value) {
  if (!value.is_number()) return {};
  return fmt::format("# HELP headway_{0} {1}\n# TYPE headway_{0} {2}\nheadway_{0} {3}\n", name, help, type,
                     value.get<double>());
}

}  // namespace

Json status_json(const LiveSession& session, const LiveStatus& status, Time now) {
  const bool heard = status.stamp != Time{};
  return {{"state", name(status.state)},
          {"reason", status.reason.data()},
          {"age_s", heard ? rounded(to_seconds(now - status.stamp), 3) : Json(nullptr)},
          {"base",
           {{"x", rounded(status.base.x)},
            {"y", rounded(status.base.y)},
            {"yaw_deg", rounded(degrees(status.base.yaw), 1)}}},
          {"at_rest", status.at_rest},
          {"goal", goal_json(status)},
          {"head", text_of(status.head)},
          {"control_computer", text_of(status.walker)},
          {"safety", safety_json(session.safety())},
          {"bus_loop", bus_loop_json(session.loops())},
          {"frames", frames_json(status.frames)},
          {"frame_level", name(status.level)},
          {"plans", status.mission.plans},
          {"replans", status.mission.replans},
          {"stage_ms",
           {{"see", rounded(milliseconds(status.times.see), 2)},
            {"map", rounded(milliseconds(status.times.map), 2)},
            {"floor", rounded(milliseconds(status.times.floor), 2)},
            {"plan", rounded(milliseconds(status.times.plan), 2)}}}};
}

std::string status_text(const Json& status) {
  const auto text = [&](const char* key) { return status.at(key).get<std::string>(); };
  const auto value = [](const Json& json, const char* key) { return json.at(key).get<double>(); };
  const std::string reason = text("reason");
  std::string lines =
      fmt::format("{:18}{}{}{}\n", "state", text("state"), reason.empty() ? "" : ": ", reason);
  const Json& safety = status.at("safety");
  lines += fmt::format("{:18}{}: {}\n", "safety", safety.at("state").get<std::string>(),
                       safety.at("reason").get<std::string>());
  const Json& base = status.at("base");
  lines += fmt::format("{:18}({:.2f}, {:.2f}) m, {:.1f} deg in the map; {}\n", "base", value(base, "x"),
                       value(base, "y"), value(base, "yaw_deg"),
                       status.at("at_rest").get<bool>() ? "at rest" : "walking");
  const Json& goal = status.at("goal");
  lines += goal.is_null() ? fmt::format("{:18}none\n", "goal")
                          : fmt::format("{:18}({:.2f}, {:.2f}) m in the map\n", "goal", value(goal, "x"),
                                        value(goal, "y"));
  lines +=
      fmt::format("{:18}{}\n{:18}{}\n", "head", text("head"), "control computer", text("control_computer"));
  const Json& frames = status.at("frames");
  lines += fmt::format("{:18}{} used, {} lost, {} without a pose, {} unusable, {} late\n", "frames",
                       value(frames, "used"), value(frames, "lost"), value(frames, "no_pose"),
                       value(frames, "unusable"), value(frames, "late"));
  const Json& bus = status.at("bus_loop");
  lines += fmt::format("{:18}{}; {} missed of {}; wakes up {:.0f} us late at most, takes {:.0f} us at most\n",
                       "bus loop", bus.at("health").get<std::string>(), value(bus, "missed"),
                       value(bus, "rounds"), value(bus, "wake_max_us"), value(bus, "run_max_us"));
  const Json& stages = status.at("stage_ms");
  lines +=
      fmt::format("{:18}see {:.1f}, map {:.1f}, floor {:.1f}, plan {:.1f} ms\n", "newest frame",
                  value(stages, "see"), value(stages, "map"), value(stages, "floor"), value(stages, "plan"));
  const Json& age = status.at("age_s");
  lines += age.is_null() ? fmt::format("{:18}no frame has been worked on yet\n", "age")
                         : fmt::format("{:18}{:.2f} s, of all above\n", "age", age.get<double>());
  return lines;
}

std::string status_metrics(const Json& status) {
  std::string text = fmt::format(
      "# HELP headway_state What the robot is about.\n# TYPE headway_state "
      "gauge\nheadway_state{{state=\"{}\"}} 1\n",
      status.at("state").get<std::string>());
  text += fmt::format(
      "# HELP headway_safety What the robot may do.\n# TYPE headway_safety "
      "gauge\nheadway_safety{{state=\"{}\"}} 1\n",
      status.at("safety").at("state").get<std::string>());
  const Json& bus = status.at("bus_loop");
  text += metric("bus_cycles_total", "counter", "Rounds of the bus loop.", bus.at("rounds"));
  text += metric("bus_cycles_missed_total", "counter", "Rounds that it missed.", bus.at("missed"));
  text +=
      metric("bus_wake_up_max_microseconds", "gauge", "How late it woke up at most.", bus.at("wake_max_us"));
  text += metric("safety_stops_total", "counter", "Stops for safety.", status.at("safety").at("stops"));
  const Json& frames = status.at("frames");
  text += metric("status_age_seconds", "gauge", "Age of what is told here.", status.at("age_s"));
  text += metric("frames_used_total", "counter", "Frames worked on.", frames.at("used"));
  text += metric("frames_lost_total", "counter", "Frames superseded or never delivered.", frames.at("lost"));
  text += metric("frames_without_pose_total", "counter", "Frames skipped for want of a pose.",
                 frames.at("no_pose"));
  text +=
      metric("frames_unusable_total", "counter", "Frames that told the map nothing.", frames.at("unusable"));
  text += metric("frames_late_total", "counter", "Frames that took longer than there was time for them.",
                 frames.at("late"));
  text += metric("plans_total", "counter", "Searches for a way.", status.at("plans"));
  text += metric("replans_total", "counter", "Plans that changed steps.", status.at("replans"));
  for (const auto& [stage, value] : status.at("stage_ms").items())
    text += fmt::format("headway_stage_milliseconds{{stage=\"{}\"}} {}\n", stage, value.get<double>());
  return text;
}

std::string answer(std::string_view question, LiveSession& session, const LiveStatus& status, Time now) {
  const auto said = [](const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  try {
    const Json asked = Json::parse(question, nullptr, false);
    if (asked.is_discarded()) throw InputError("not JSON, expected an object such as {\"do\": \"status\"}");
    Json done = do_what(asked, session, status, now);
    done["ok"] = true;
    return said(done);
  } catch (const std::exception& fault) {
    return said(Json{{"ok", false}, {"error", config::one_line(fault.what())}});
  }
}

}  // namespace headway::app
