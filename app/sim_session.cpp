#include "app/sim_session.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "app/loop_configs.h"
#include "app/loop_setup.h"
#include "app/simulated_robot.h"
#include "app/world_map.h"
#include "hal/error.h"
#include "hal/on_floor.h"
#include "vision/rectify.h"

namespace headway::app {

namespace {

bool on_floor(const sim::World& world, const Eigen::Vector2d& p) {
  const Eigen::Vector2d d = (p - world.floor.centre).cwiseAbs();
  return d.x() < world.floor.size.x() / 2 && d.y() < world.floor.size.y() / 2;
}

/// Throws InputError unless the robot may be sent there.
void check_goal(const nav::Goal& goal, const sim::World& world, const nav::FloorMapConfig& floor,
                const std::string& from) {
  const Eigen::Vector2d& p = goal.position;
  if (!p.allFinite() || (goal.yaw && !std::isfinite(*goal.yaw)))
    throw InputError(fmt::format("{}: is not finite, expected numbers", from));
  if (!on_floor(world, p))
    throw InputError(
        fmt::format("{}: ({:.2f}, {:.2f}) lies outside the floor of world '{}', expected x within "
                    "{:.2f} of {:.2f} and y within {:.2f} of {:.2f}",
                    from, p.x(), p.y(), world.name, world.floor.size.x() / 2, world.floor.centre.x(),
                    world.floor.size.y() / 2, world.floor.centre.y()));
  if (goal.near) return;
  if (const sim::Thing* thing = sim::obstacle_at(world, p, floor.floor_tolerance, floor.body_height))
    throw InputError(
        fmt::format("{}: ({:.2f}, {:.2f}) lies in an obstacle ({}) of world '{}', expected free "
                    "floor",
                    from, p.x(), p.y(), thing->name, world.name));
}

nav::Goal goal_of(const Robot& robot, const sim::World& world, const SimOptions& options) {
  if (options.waits && !options.goal) return {world.start.position(), std::nullopt};
  if (!options.goal && !world.goal)
    throw InputError(fmt::format("world '{}': has no goal; give one with --goal X,Y[,YAW]", world.name));
  if (!on_floor(world, world.start.position()))
    throw InputError(fmt::format("world '{}': start: lies outside the floor", world.name));
  nav::Goal goal;
  if (options.goal)
    goal = *options.goal;
  else
    goal = {world.goal->position, world.goal->yaw};
  goal.near = options.near;
  check_goal(goal, world, robot.mapper.obstacle_heights(), options.goal ? "--goal" : "goal");
  return goal;
}

DemandConfig demands(const Robot& robot) {
  DemandConfig config{.steps = robot.steps, .step = robot.mission.gait.step_duration};
  if (robot.mission.gait.over.height > 0)
    config.step = std::max(config.step, robot.mission.gait.over.duration);
  return config;
}

Robot set_up(const Robot& robot, const sim::World& world, const SimOptions& options) {
  return with(loop_setup(robot, world, options), robot);
}

}  // namespace

SimSession::SimSession(const Robot& robot, const sim::World& world, const SimOptions& options)
    : robot_(set_up(robot, world, options)),
      goal_(goal_of(robot, world, options)),
      options_(options),
      scene_(world),
      body_(simulated_robot(robot_, options), world.start),
      taps_(options.recorder),
      bus_(taps_.bus(body_.bus(), clock_)),
      head_(bus_, head_config(robot_)),
      walker_(bus_),
      links_(std::make_unique<runtime::Links>()),
      line_(*links_),
      mapper_(robot_.mapper, world.start),
      mission_(robot_.mission, mapper_.floor().grid),
      bus_loop_(bus_config(robot_, world.start), bus_, head_, walker_, *links_),
      frames_(frame_config(robot_, robot_.simulation.frame_rate), make_eyes(), mapper_, mission_, *links_,
              taps_.stopwatch(stopwatch_)),
      lockstep_(
          {sim::SimRobot::kPeriod, robot_.simulation.charge, robot_.loops.missed}, clock_,
          [this](Time now) { move_world(now); }, bus_loop_, frames_),
      onlooker_{[this](const Eigen::Vector3d& p) { return in_sight(p); },
                robot_.mission.outline.bare().reach(),
                robot_.mission.gait.forward / to_seconds(robot_.mission.gait.step_duration)},
      reactions_(robot_.mission.outline, robot_.mapper.floor, onlooker_),
      body_mask_(robot_.mission.outline, mapper_.floor().grid),
      faults_(options.faults, demands(robot_)) {
  body_.on_exposure([this](Time t, const Eigen::Isometry3d& map_from_camera) {
    if (stereo_camera_) stereo_camera_->expose(t, map_from_camera);
    const Eigen::Isometry3d map_from_view = map_from_camera * eyes_->left_from_view();
    if (depth_camera_) depth_camera_->expose(t, map_from_view);
    precision_.expose(t, scene_, sight_.camera, map_from_view);
    reactions_.expose(t, scene_, sight_, map_from_view, body_.stance().base().position());
  });
  body_.on_touch([this](const sim::BodyBox& box, Time) { return touched(scene_, box); });
  frames_.observe([this](const runtime::FrameSnapshot& snapshot) {
    precision_.judge(snapshot.stamp.exposure, snapshot.view);
    note_sight(snapshot.stamp.exposure);
    watch(snapshot);
    taps_.see(snapshot);
    if (observer_) observer_(snapshot);
  });
  if (fault_schedule()) lockstep_.starve([this](Time now) { return starved(now); });
  taps_.watch(bus_loop_, frames_);
  if (options.waits && !options.goal) return;
  taps_.set(goal_, clock_.now());
  mission_.set_goal(goal_);
}

const sim::FaultSchedule* SimSession::fault_schedule() const {
  return options_.faults.empty() ? nullptr : &body_.faults();
}

runtime::Lockstep::Starved SimSession::starved(Time now) const {
  const auto on = [&](sim::FaultKind kind) { return body_.faults().any(kind, now); };
  const bool both = on(sim::FaultKind::kStarvedLoops);
  return {both || on(sim::FaultKind::kStarvedBusLoop), both || on(sim::FaultKind::kStarvedFrameLoop)};
}

runtime::Eyes& SimSession::make_eyes() {
  const vision::Rectifier rectifier(robot_.rig);
  sight_ = {rectifier.camera(), rectifier.rig().baseline, robot_.rig.nearest, robot_.rig.farthest};
  if (options_.range_mode) {
    const auto model = simulated_depth(robot_, rectifier.rig(), options_.seed);
    sight_.camera = {model.width, model.height, model.focal, model.cx, model.cy};
    depth_camera_ = std::make_unique<sim::SimDepthCamera>(scene_, clock_, model, fault_schedule());
    eyes_ = std::make_unique<runtime::DepthEyes>(
        taps_.camera(*depth_camera_), depth_eyes(model, rectifier.rectified_from_left().inverse()));
  } else {
    const auto model = simulated_pair(robot_.rig, options_.seed);
    stereo_camera_ = std::make_unique<sim::SimStereoCamera>(scene_, clock_, model, fault_schedule());
    auto eyes =
        std::make_unique<runtime::StereoEyes>(taps_.camera(*stereo_camera_), robot_.rig, robot_.vision);
    stereo_eyes_ = eyes.get();
    eyes_ = std::move(eyes);
  }
  return *eyes_;
}

void SimSession::note_sight(Time exposure) {
  if (!stereo_eyes_) return;
  for (const vision::SightFinding& finding : stereo_eyes_->sight().findings) {
    const auto known =
        std::find_if(sight_findings_.begin(), sight_findings_.end(), [&](const SimSightFinding& f) {
          return f.first.fault == finding.fault && f.first.severity == finding.severity;
        });
    if (known == sight_findings_.end())
      sight_findings_.push_back({finding, exposure, 1});
    else
      ++known->frames;
  }
}

void SimSession::watch(const runtime::FrameSnapshot& snapshot) {
  reactions_.decide(snapshot.stamp.exposure, snapshot.map_from_view, snapshot.mission, snapshot.bus.committed,
                    snapshot.order);
  if (snapshot.mission.walk()) body_mask_.plan(snapshot.mission.walk()->path);
}

bool SimSession::in_sight(const Eigen::Vector3d& point) const {
  const Eigen::Isometry3d map_from_view = body_.map_from_camera() * eyes_->left_from_view();
  return sight_.in_view(map_from_view.inverse() * point) && sight_.in_sight(scene_, map_from_view, point);
}

void SimSession::move_world(Time now) {
  scene_.advance(now, body_.stance().base(), &onlooker_);
  body_.step(now);
}

void SimSession::note() {
  const Pose2 map_from_odom = frames_.localisation().map_from_odom();
  runtime::StepRecord record;
  while (links_->steps.pop(record)) {
    record.landing = map_from_odom * record.landing;
    steps_.push_back(record);
  }
  if (fault_schedule()) note_faults();
  note_progress();
  reactions_.handed(clock_.now(), bus_loop_);
  body_mask_.handed(clock_.now(), bus_loop_.counters());
  if (clock_.now().time_since_epoch() % BodyMaskCheck::kPeriod == Duration(0) && !steps_.empty())
    body_mask_.judge(steps_, body_.shape());
  if (events_.empty() || events_.back().state != mission_.state())
    events_.push_back(
        {clock_.now(), mission_.state(), map_from_odom * links_->report.value().committed.stance.base()});
  if (clock_.now().time_since_epoch() % SimTrail::kPeriod != Duration(0)) return;
  trail_.truth.push_back(body_.stance().base());
  trail_.believed.push_back(map_from_odom * headway::on_floor(walker_.chest().odom_from_chest));
  if (progress_) progress_();
}

void SimSession::send_to(const nav::Goal& goal) {
  check_goal(goal, scene_.world(), robot_.mapper.obstacle_heights(), "goal");
  goal_ = goal;
  taps_.set(goal, clock_.now());
  mission_.set_goal(goal);
  steps_.clear();
  trail_ = {};
  events_.clear();
}

void SimSession::note_faults() {
  ProgramSigns signs;
  signs.frames = frames_.counters();
  signs.cycles_missed = lockstep_.missed();
  signs.unused = walker_.counts();
  signs.head = head_.state().health;
  signs.control = walker_.health();
  signs.reject = walker_.status().reject_reason;
  signs.clock_known = walker_.clock().has_value();
  signs.bus = body_.bus().state();
  signs.committed = bus_loop_.committed();
  signs.braking = body_.control().pattern().closed();
  signs.phase_remaining = body_.control().pattern().phase_remaining();
  faults_.look(clock_.now(), body_.faults(), signs);
}

void SimSession::note_progress() {
  const bool walks = body_.control().pattern().phase() != nav::WalkingPattern::Phase::kStanding;
  if (!walks && mission_.views_taken() == views_) return;
  views_ = mission_.views_taken();
  progress_at_ = clock_.now();
}

void SimSession::step() {
  lockstep_.step();
  note();
  if (options_.recorder) options_.recorder->pump();
}

SimOutcome SimSession::run_while(const std::function<bool()>& go_on) {
  while (go_on()) {
    step();
    if (body_.fallen()) return judge("fall");
    if (body_.collision()) return judge("collision");
  }
  return judge("ended");
}

SimOutcome SimSession::run() {
  const Time end = clock_.now() + options_.longest;
  while (clock_.now() < end) {
    step();
    if (body_.fallen()) return judge("fall");
    if (body_.collision()) return judge("collision");
    if (mission_.state() == runtime::MissionState::kArrived) return judge("arrived");
    if (mission_.state() == runtime::MissionState::kStopped &&
        walker_.status().state == hal::WalkState::kStanding)
      return judge("stopped");
    if (clock_.now() - progress_at_ >= kStandstill) return judge("stopped");
  }
  return judge("time");
}

SimOutcome SimSession::judge(std::string end) const {
  SimOutcome out;
  out.end = std::move(end);
  out.fallen = body_.fallen();
  out.collision = body_.collision();
  out.reason = mission_.reason();
  if (out.end == "stopped" && out.reason.empty())
    out.reason = fmt::format("has stood for {:.0f} s without a new view, and waits ({})",
                             to_seconds(kStandstill), name(mission_.state()));
  if (out.collision)
    out.reason = fmt::format("the {} touched {} after {:.2f} s", out.collision->part, out.collision->object,
                             to_seconds(out.collision->time));
  if (out.fallen) out.reason = fmt::format("the robot fell after {:.2f} s", to_seconds(clock_.now()));
  if (out.end == "time") out.reason = fmt::format("not done after {:.0f} s", to_seconds(options_.longest));
  const Pose2 base = body_.stance().base();
  out.goal_error = (base.position() - goal_.position).norm();
  if (goal_.yaw) out.goal_yaw_error = std::abs(wrap_angle(base.yaw - *goal_.yaw));
  if (out.end == "arrived") out.short_of_goal = mission_.short_of_goal();
  out.arrived = out.end == "arrived" && out.goal_error <= out.short_of_goal + kArrivedWithin &&
                out.goal_yaw_error.value_or(0) <= kArrivedWithinYaw;
  if (out.end == "arrived" && !out.arrived) {
    out.end = "missed";
    out.reason = fmt::format(
        "believes to be at the goal, and is {:.2f} m{} off it", out.goal_error,
        out.goal_yaw_error ? fmt::format(" and {:.1f} degrees", *out.goal_yaw_error * 180 / std::numbers::pi)
                           : "");
  }
  const Pose2 by_odometry = links_->report.value().committed.stance.base();
  out.odometry_error = (base.position() - by_odometry.position()).norm();
  out.map_error =
      (base.position() - (frames_.localisation().map_from_odom() * by_odometry).position()).norm();
  out.walked = body_.path_walked();
  out.seconds = to_seconds(clock_.now());
  return out;
}

}  // namespace headway::app
