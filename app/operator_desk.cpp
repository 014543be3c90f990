#include "app/operator_desk.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "config/yaml_limits.h"
#include "hal/error.h"

namespace headway::app {

namespace {

constexpr double kFarthest = 500;  // of a goal, along each axis [m]
constexpr std::size_t kMostGoals = 50;
constexpr Duration kStatusTakes = seconds(2);  // until it surely tells of a goal that was sent
constexpr std::size_t kMostWalks = 3;          // that are weighed for the next view

/// A key that is none of these is more likely a mistake than nothing.
void require_keys(const Json& body, std::initializer_list<std::string_view> known) {
  for (const auto& [key, value] : body.items())
    if (std::ranges::find(known, key) == known.end()) {
      std::string list;
      for (const std::string_view k : known) list += (list.empty() ? "" : ", ") + std::string(k);
      throw InputError(fmt::format("{}: no such key, expected {}", key, list.empty() ? "none" : list));
    }
}

double checked(const Json& value, std::string_view key, double lowest, double highest) {
  if (!value.is_number() || !(value.get<double>() >= lowest && value.get<double>() <= highest))
    throw InputError(fmt::format("{}: expected a number from {:g} to {:g}", key, lowest, highest));
  return value.get<double>();
}
double number(const Json& body, const char* key, double lowest, double highest) {
  const auto found = body.find(key);
  if (found == body.end()) throw InputError(fmt::format("{}: is missing, expected a number", key));
  return checked(*found, key, lowest, highest);
}
bool flag(const Json& body, const char* key) {
  const auto found = body.find(key);
  if (found == body.end()) return false;
  if (!found->is_boolean()) throw InputError(fmt::format("{}: expected true or false", key));
  return found->get<bool>();
}

double seconds_of(const nav::Walk& walk) {
  Duration all{};
  for (const hal::Footstep& step : walk.steps) all += step.duration;
  return to_seconds(all);
}

double metres_of(const nav::Walk& walk, const Pose2& from) {
  double all = 0;
  Eigen::Vector2d last = from.position();
  for (const Pose2& base : walk.bases) {
    all += (base.position() - last).norm();
    last = base.position();
  }
  return all;
}

bool walks(const LiveStatus& status) {
  return status.goal && status.state != runtime::MissionState::kArrived &&
         status.state != runtime::MissionState::kStopped;
}

std::string next_of(const LiveStatus& status) {
  using State = runtime::MissionState;
  const std::string there =
      status.goal ? fmt::format("({:.2f}, {:.2f})", status.goal->position.x(), status.goal->position.y())
                  : "";
  switch (status.state) {
    case State::kStarting:
      return "waits for the head's drives and the control computer";
    case State::kLookAround:
      return status.goal ? "looks around, then walks to " + there : "looks around, then waits";
    case State::kWaitGoal:
      return "stays until it is sent somewhere";
    case State::kWalk:
      return "walks to " + there;
    case State::kLookAhead:
      return "looks at the floor ahead, then walks on to " + there;
    case State::kArrived:
      return "stays where it is: it has arrived";
    case State::kStopped:
      return "stays where it is until it is sent somewhere";
  }
  return "";
}

}  // namespace

OperatorDesk::OperatorDesk(const Robot& robot, const nav::FloorGrid& grid, const Pose2& home,
                           runtime::OperatorLine& line)
    : grid_(grid),
      home_(home),
      head_(robot.mission.head),
      line_(line),
      ways_(robot.mission.planner, robot.mission.gait, robot.mission.outline, robot.mission.execution, grid),
      next_view_({robot.mission.field, robot.mission.neck, robot.mission.head, robot.chest_height},
                 robot.mapper.voxels.resolution, robot.mission.next_view.value_or(nav::NextViewConfig{})),
      planner_(robot.mission.planner, robot.mission.gait, robot.mission.outline, grid),
      gait_(robot.mission.gait) {}

void OperatorDesk::see(const runtime::FrameSnapshot& snapshot) {
  constexpr Duration kEvery = seconds(0.2);
  if (snapshot.stamp.exposure - ground_at_ < kEvery) return;
  ground_at_ = snapshot.stamp.exposure;
  next_ground_.floor = snapshot.mapper.floor();
  next_ground_.committed = snapshot.bus.committed;
  next_ground_.head = snapshot.bus.head.position;
  next_ground_.map_from_chest = snapshot.map_from_chest;
  const nav::VoxelMap& voxels = snapshot.mapper.voxels();
  if (snapshot.bus.committed.at_rest && voxels.changes() != voxel_changes_) {
    next_ground_.voxels = std::make_shared<const nav::VoxelMap>(voxels);
    voxel_changes_ = voxels.changes();
  }
  next_ground_.known = true;
  ground_.publish(next_ground_);
}

const std::map<std::string_view, OperatorDesk::Service>& OperatorDesk::services() {
  static const std::map<std::string_view, Service> all{
      {"lease", &OperatorDesk::lease},
      {"plan_preview", &OperatorDesk::plan_preview},
      {"plan_confirm", &OperatorDesk::plan_confirm},
      {"forget_plan", &OperatorDesk::forget_plan},
      {"pause", &OperatorDesk::pause},
      {"resume", &OperatorDesk::resume},
      {"look", &OperatorDesk::look},
      {"look_around", &OperatorDesk::look_around},
      {"explore_preview", &OperatorDesk::explore_preview},
      {"go_home", &OperatorDesk::go_home},
      {"tour", &OperatorDesk::tour},
      {"record", &OperatorDesk::record},
      {"reset", &OperatorDesk::reset},
  };
  return all;
}

std::string OperatorDesk::answer(std::uint64_t client, std::string_view service, const std::string& body,
                                 const LiveStatus& status, Time now) {
  const auto said = [](const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  if (service == "stop") {  // whatever else it says
    stop();
    return said(Json{{"ok", true}});
  }
  try {
    const auto found = services().find(service);
    if (found == services().end()) throw InputError(fmt::format("{}: no such service", service));
    const Json asked = Json::parse(body, nullptr, false);
    if (!asked.is_object()) throw InputError("expected a JSON object");
    Json done = (this->*found->second)(client, asked, status, now);
    if (!done.contains("ok")) done["ok"] = true;
    return said(done);
  } catch (const std::exception& fault) {
    return said(Json{{"ok", false}, {"error", config::one_line(fault.what())}});
  }
}

/// Who gives control up leaves nothing behind that the next one would take over unseen.
Json OperatorDesk::lease(std::uint64_t, const Json& body, const LiveStatus&, Time now) {
  const auto whole = [&](const char* key) {
    return static_cast<std::uint32_t>(number(body, key, 0, 4294967295.0));
  };
  if (std::exchange(released_, whole("released")) != whole("released")) stop();
  line_.hold(whole("lease"), now - Duration(body.at("age_ns").get<Duration::rep>()));
  return Json::object();
}

void OperatorDesk::forget_intentions() {
  tour_.clear();
  paused_.reset();
  exploring_ = false;
  if (show_) show_({});
}

void OperatorDesk::stop() {
  line_.stay();
  plans_.clear();
  forget_intentions();
}

void OperatorDesk::require_in_use(const nav::Goal& goal) const {
  if (grid_.contains(grid_.cell(goal.position))) return;
  const Eigen::Vector2d end = grid_.origin + grid_.resolution * Eigen::Vector2d(grid_.width, grid_.height);
  throw InputError(fmt::format(
      "({:.2f}, {:.2f}) lies outside the floor in use, expected x from {:.1f} to {:.1f} and y from {:.1f} "
      "to {:.1f} m",
      goal.position.x(), goal.position.y(), grid_.origin.x(), end.x(), grid_.origin.y(), end.y()));
}

const OperatorDesk::Ground& OperatorDesk::ground() {
  ground_.update();
  if (!ground_.value().known) throw Error("it is not known yet where the robot stands; ask again");
  return ground_.value();
}

runtime::Way OperatorDesk::way_to(const nav::Goal& goal) {
  require_in_use(goal);
  const Ground& now = ground();
  return ways_.find(now.floor, now.committed, goal);
}

Json OperatorDesk::show_plan(std::uint64_t client, std::deque<nav::Goal> goals, Time now) {
  for (const nav::Goal& goal : goals) require_in_use(goal);
  const runtime::Way way = way_to(goals.front());
  if (!way.plan) {
    if (show_) show_({});
    Json refused{{"ok", false}, {"error", fmt::format("no way there: {}", nav::describe(way.plan.reason))}};
    if (way.plan.nearest)
      refused["nearest"] = {rounded(way.plan.nearest->x()), rounded(way.plan.nearest->y())};
    return refused;
  }
  return keep_plan(client, {.goals = std::move(goals), .look = {}}, way, now);
}

Json OperatorDesk::keep_plan(std::uint64_t client, Plan plan, const runtime::Way& way, Time now) {
  plan.id = ++last_plan_;
  plan.made = now;
  const Pose2 from = ground_.value().committed.stance.base();
  Json poses = Json::array();
  for (const Pose2& base : way.walk.bases)
    poses.push_back({rounded(base.x), rounded(base.y), rounded(base.yaw)});
  Json shown{{"plan", plan.id},
             {"metres", rounded(metres_of(way.walk, from), 2)},
             {"seconds", rounded(seconds_of(way.walk), 1)},
             {"steps", way.walk.steps.size()},
             {"way", std::move(poses)}};
  if (!plan.goals.empty()) {
    const nav::Goal& goal = plan.goals.front();
    shown["x"] = rounded(goal.position.x());
    shown["y"] = rounded(goal.position.y());
    if (const std::string shortfall = nav::describe_shortfall(way.plan, goal); !shortfall.empty())
      shown["note"] = shortfall;
  }
  if (show_) show_(way.walk.bases);
  std::erase_if(plans_, [&](const auto& kept) { return now - kept.second.made > kPlanHolds; });
  plans_[client] = std::move(plan);
  return shown;
}

Json OperatorDesk::plan_preview(std::uint64_t client, const Json& body, const LiveStatus&, Time now) {
  require_keys(body, {"x", "y", "yaw_deg", "near"});
  nav::Goal goal;
  goal.position = {number(body, "x", -kFarthest, kFarthest), number(body, "y", -kFarthest, kFarthest)};
  if (body.contains("yaw_deg"))
    goal.yaw = wrap_angle(number(body, "yaw_deg", -360, 360) * std::numbers::pi / 180);
  goal.near = flag(body, "near");
  return show_plan(client, {goal}, now);
}

Json OperatorDesk::go_home(std::uint64_t client, const Json& body, const LiveStatus&, Time now) {
  require_keys(body, {});
  return show_plan(client, {nav::Goal{home_.position(), home_.yaw}}, now);
}

Json OperatorDesk::tour(std::uint64_t client, const Json& body, const LiveStatus&, Time now) {
  require_keys(body, {"goals"});
  const auto list = body.find("goals");
  if (list == body.end() || !list->is_array() || list->empty() || list->size() > kMostGoals)
    throw InputError(fmt::format("goals: expected 1 to {} places, each [x, y] in metres", kMostGoals));
  std::deque<nav::Goal> goals;
  for (const Json& place : *list) {
    if (!place.is_array() || place.size() != 2)
      throw InputError(fmt::format("goals[{}]: expected [x, y] in metres", goals.size()));
    nav::Goal goal;
    goal.position = {checked(place[0], "x", -kFarthest, kFarthest),
                     checked(place[1], "y", -kFarthest, kFarthest)};
    goals.push_back(goal);
  }
  return show_plan(client, std::move(goals), now);
}

/// What shows most for each second that it takes: a look from here, or from where a walk leads.
Json OperatorDesk::explore_preview(std::uint64_t client, const Json& body, const LiveStatus& status,
                                   Time now) {
  require_keys(body, {});
  if (walks(status)) throw InputError("where to look next is found at rest; stop the robot first");
  const Ground& known = ground();
  if (!known.voxels) throw Error("nothing has been looked at yet; ask again");
  auto looks = next_view_.turns(*known.voxels, known.map_from_chest, known.head);
  const auto ahead = next_view_.walks(*known.voxels, known.floor, planner_, gait_,
                                      known.committed.stance.base(), kMostWalks);
  looks.insert(looks.end(), ahead.begin(), ahead.end());
  std::ranges::stable_sort(looks, std::greater<>(), &nav::NextLook::rate);
  if (looks.empty()) {
    exploring_ = false;
    throw Error("nothing is left that a look would show");
  }
  return show_look(client, looks.front(), now);
}

Json OperatorDesk::show_look(std::uint64_t client, const nav::NextLook& look, Time now) {
  const auto degrees = [](double radians) { return rounded(radians * 180 / std::numbers::pi, 1); };
  const Json view{{"pan_deg", degrees(look.head.pan)},
                  {"tilt_deg", degrees(look.head.tilt)},
                  {"gain", rounded(look.gain, 2)},
                  {"seconds", rounded(look.seconds, 1)}};
  Plan plan{.goals = {}, .look = {}, .explores = true};
  runtime::Way way;
  if (look.stance) {
    plan.goals.push_back({look.stance->position(), look.stance->yaw});
    way = way_to(plan.goals.front());
    if (!way.plan) throw Error(fmt::format("no way to the next view: {}", nav::describe(way.plan.reason)));
  } else {
    plan.look = look.head;
  }
  Json shown = keep_plan(client, std::move(plan), way, now);
  shown["view"] = view;
  return shown;
}

Json OperatorDesk::forget_plan(std::uint64_t client, const Json& body, const LiveStatus&, Time) {
  require_keys(body, {});
  plans_.erase(client);
  if (show_) show_({});
  return Json::object();
}

Json OperatorDesk::plan_confirm(std::uint64_t client, const Json& body, const LiveStatus&, Time now) {
  require_keys(body, {"plan"});
  const auto id = static_cast<std::uint32_t>(number(body, "plan", 0, 4294967295.0));
  const auto kept = plans_.find(client);
  if (kept == plans_.end() || kept->second.id != id)
    throw InputError(fmt::format("plan {}: is not the newest that was shown to you; look at a new one", id));
  Plan plan = std::move(kept->second);
  plans_.erase(kept);
  if (now - plan.made > kPlanHolds)
    throw InputError(
        fmt::format("plan {}: was shown {:.0f} s ago, and much may have moved; look at a new one", id,
                    to_seconds(now - plan.made)));
  if (plan.look) {
    line_.look({.around = false, .head = *plan.look});
  } else {
    send(plan.goals.front(), now);
    plan.goals.pop_front();
  }
  forget_intentions();
  tour_ = std::move(plan.goals);
  exploring_ = plan.explores;
  return Json::object();
}

void OperatorDesk::send(const nav::Goal& goal, Time now) {
  line_.go(goal);
  sent_ = Sent{goal, now, line_.safety().stops};
}

Json OperatorDesk::pause(std::uint64_t, const Json& body, const LiveStatus& status, Time) {
  require_keys(body, {});
  if (!walks(status)) throw InputError("nothing is walked that could be paused");
  line_.stay();
  paused_ = status.goal;
  pause_seen_ = false;
  return Json::object();
}

Json OperatorDesk::resume(std::uint64_t, const Json& body, const LiveStatus&, Time now) {
  require_keys(body, {});
  if (!paused_) throw InputError("nothing is paused");
  send(*paused_, now);
  paused_.reset();
  return Json::object();
}

Json OperatorDesk::look(std::uint64_t, const Json& body, const LiveStatus& status, Time) {
  require_keys(body, {"pan", "tilt"});
  if (walks(status) || status.state == runtime::MissionState::kLookAround)
    throw InputError("the head looks where the robot walks; stop it first");
  runtime::LookOrder order;
  order.head = {number(body, "pan", head_.lower.pan, head_.upper.pan),
                number(body, "tilt", head_.lower.tilt, head_.upper.tilt)};
  line_.look(order);
  return Json::object();
}

Json OperatorDesk::look_around(std::uint64_t, const Json& body, const LiveStatus& status, Time) {
  require_keys(body, {});
  if (walks(status)) throw InputError("the head looks where the robot walks; stop it first");
  line_.look({.around = true, .head = {}});
  return Json::object();
}

Json OperatorDesk::record(std::uint64_t, const Json& body, const LiveStatus&, Time) {
  require_keys(body, {"on"});
  if (!body.contains("on")) throw InputError("on: is missing, expected true or false");
  if (!record_) throw InputError("nothing is recorded here");
  record_(flag(body, "on"));
  return Json::object();
}

Json OperatorDesk::reset(std::uint64_t, const Json& body, const LiveStatus&, Time) {
  require_keys(body, {});
  line_.reset();
  return Json::object();
}

/// A pause ends when somebody else has sent the robot on. A goal of the list was reached: the next one;
/// whatever else ended the walk ends the list.
void OperatorDesk::attend(const LiveStatus& status, Time now) {
  if (paused_) {
    pause_seen_ = pause_seen_ || !walks(status);
    if (pause_seen_ && walks(status)) forget_intentions();
    return;
  }
  if (tour_.empty() || !sent_) return;
  if (line_.safety().stops != sent_->stops) return tour_.clear();
  if (!status.goal || status.goal->position != sent_->goal.position) return;
  sent_->under_way = sent_->under_way || walks(status);
  // The status may be of before that goal was sent.
  const bool may_be_old = !sent_->under_way && now - sent_->at < kStatusTakes;
  if (status.state == runtime::MissionState::kStopped && !may_be_old) tour_.clear();
  if (status.state != runtime::MissionState::kArrived || may_be_old) return;
  try {
    send(tour_.front(), now);
    tour_.pop_front();
  } catch (const std::exception&) {
    tour_.clear();
  }
}

void OperatorDesk::fill(remote::OperatorStatus& out, const LiveStatus& status) const {
  out.paused = paused_.has_value();
  out.tour_left = static_cast<std::uint32_t>(tour_.size());
  out.exploring = exploring_;
  out.recording = recording_.on;
  out.record_folder = record_folder_;
  out.record_file = recording_.file;
  out.record_mib = static_cast<double>(recording_.bytes) / (1 << 20);
  out.record_dropped = recording_.dropped;
  out.record_fault = recording_.fault;
  out.next = paused_ ? "stays where it is until it is told to go on" : next_of(status);
  if (!tour_.empty()) out.next += fmt::format("; {} more to come", tour_.size());
}

}  // namespace headway::app
