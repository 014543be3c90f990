#include "sim_hal/robot.h"

#include <algorithm>
#include <string>

#include "hal/bus_codec.h"
#include "hal/error.h"
#include "hal/pose_history.h"

namespace headway::sim {
namespace {

void require(bool ok, const std::string& what) {
  if (!ok) throw InputError("robot: " + what);
}

BodyBox box(std::string part, const Pose2& pose, double length, double width, double low, double high) {
  return {std::move(part), pose.lifted((low + high) / 2), {length, width, high - low}};
}

}  // namespace

void BodyShapeConfig::validate() const {
  const auto part = [](const std::string& name, double depth, double width, double low, double high) {
    require(depth > 0 && width > 0, "shape." + name + ": sizes must be positive");
    require(low >= 0 && high > low,
            "shape." + name + ": it must end above where it begins, both above the floor");
  };
  part("torso", torso_depth, torso_width, torso_low, torso_high);
  part("legs", legs_depth, legs_width, legs_low, legs_high);
  part("head", head_depth, head_width, head_low, head_high);
  part("foot", foot_length, foot_width, foot_low, foot_high);
}

void RobotConfig::validate() const {
  bus.validate();
  pan.validate();
  tilt.validate();
  control.validate();
  body.validate();
  shape.validate();
  require(pan.node != tilt.node, "pan and tilt need different nodes");
  require(feet_apart > body.sole_width && feet_apart < 0.5,
          "feet_apart must lie between a sole's width and 0.5 m");
  require(frame_rate >= 0 && frame_rate <= 200, "frame_rate must lie between 0 and 200 Hz");
  require(first_exposure >= Duration{}, "first_exposure must not be negative");
  sim::validate(faults);
}

SimRobot::SimRobot(const RobotConfig& config, const Pose2& start, Time begin)
    : config_((config.validate(), config)),
      begin_(begin),
      now_(begin),
      can_(config.bus, begin),
      vision_end_(can_.attach("vision")),
      pan_end_(can_.attach("pan")),
      tilt_end_(can_.attach("tilt")),
      control_end_(can_.attach("control")),
      pan_(config.pan, pan_end_, begin),
      tilt_(config.tilt, tilt_end_, begin),
      control_(config.control, hal::Stance::parallel(start, config.feet_apart), control_end_, begin),
      body_(config.body, control_.walking()),
      chest_(body_.map_from_chest()),
      faults_(config.faults, begin, config.fault_seed),
      fault_on_(config.faults.size(), false),
      frames_asked_(config.faults.size(), 0) {
  pan_end_.listen(pan_);
  tilt_end_.listen(tilt_);
  control_end_.listen(control_);
  prepare_faults();
}

Eigen::Isometry3d SimRobot::map_from_camera() const {
  return chest_ * config_.kinematics.chest_from_camera(head());
}

void SimRobot::step(Time now) {
  const Time before = now_;
  const Eigen::Isometry3d chest_before = chest_;
  const hal::HeadAngles head_before = head();

  apply_faults(now);
  can_.advance(now);
  pan_.tick(now);
  tilt_.tick(now);
  control_.tick(now);
  body_.tick(control_.walking(), to_seconds(now - before));
  if (body_.fallen()) control_.fail();
  chest_ = body_.map_from_chest();
  now_ = now;

  take_pictures(before, chest_before, head_before);
  check_touch();
}

/// Exposures since the last step, each at its own time.
void SimRobot::take_pictures(Time before, const Eigen::Isometry3d& chest_before,
                             const hal::HeadAngles& head_before) {
  if (config_.frame_rate <= 0) return;
  while (true) {
    const Time exposure =
        begin_ + config_.first_exposure + seconds(static_cast<double>(exposures_) / config_.frame_rate);
    if (exposure > now_) return;
    ++exposures_;
    if (!expose_) continue;
    const double share = to_seconds(exposure - before) / to_seconds(now_ - before);
    const Eigen::Isometry3d chest = hal::interpolate(chest_before, chest_, share);
    expose_(exposure,
            chest * config_.kinematics.chest_from_camera(hal::interpolate(head_before, head(), share)));
  }
}

std::vector<BodyBox> SimRobot::shape() const {
  const BodyShapeConfig& s = config_.shape;
  const Pose2 trunk{chest_.translation().x(), chest_.translation().y(), body_.yaw()};
  const Pose2 head = trunk * Pose2{0, 0, pan_.angle()};
  const auto foot = [&](std::string name, hal::Foot f) {
    const nav::FootPose& at = body_.foot(f);
    return box(std::move(name), at.pose, s.foot_length, s.foot_width, at.z + s.foot_low, at.z + s.foot_high);
  };
  return {box("torso", trunk, s.torso_depth, s.torso_width, s.torso_low, s.torso_high),
          box("legs", map_from_base(), s.legs_depth, s.legs_width, s.legs_low, s.legs_high),
          box("head", head, s.head_depth, s.head_width, s.head_low, s.head_high),
          foot("left foot", hal::Foot::kLeft), foot("right foot", hal::Foot::kRight)};
}

/// Notices the first contact.
void SimRobot::check_touch() {
  if (!touched_ || collision_) return;
  for (const BodyBox& part : shape()) {
    std::optional<std::string> object = touched_(part, now_);
    if (!object) continue;
    collision_ = {now_, part.part, *std::move(object)};
    return;
  }
}

/// Whether the fault is on and hits the frame.
bool SimRobot::hits(std::size_t index, FaultKind kind, const hal::CanFrame& frame) {
  const Fault& fault = faults_.plan()[index];
  if (!fault_on_[index] || fault.kind != kind || (fault.id != kAnyId && fault.id != frame.id)) return false;
  return faults_.draw(index, frames_asked_[index]++) < fault.share;
}

Duration SimRobot::lateness(const hal::CanFrame& frame) {
  Duration late{};
  for (std::size_t i = 0; i < faults_.plan().size(); ++i) {
    const bool slow = frame.id >= hal::bus::StepCommand::kId && frame.id <= hal::bus::ControlTime::kId &&
                      hits(i, FaultKind::kSlowControl, frame);
    if (slow || hits(i, FaultKind::kCanDelay, frame)) late = std::max(late, faults_.plan()[i].delay);
  }
  return late;
}

void SimRobot::prepare_faults() {
  const std::size_t count = faults_.plan().size();
  if (count == 0) return;
  can_.drop_if([this, count](const hal::CanFrame& f) {
    for (std::size_t i = 0; i < count; ++i)
      if (hits(i, FaultKind::kCanLoss, f)) return true;
    return false;
  });
  can_.corrupt_by([this, count](const hal::CanFrame& f) -> std::optional<unsigned> {
    for (std::size_t i = 0; i < count; ++i)
      if (f.dlc > 0 && hits(i, FaultKind::kCanCorruption, f))
        return static_cast<unsigned>(faults_.draw(i, ~frames_asked_[i]) * 8 * f.dlc);
    return std::nullopt;
  });
  can_.delay_by([this](const hal::CanFrame& f) { return lateness(f); });
}

void SimRobot::apply_faults(Time now) {
  if (control_.pattern().started() > 0) faults_.first_step(now);
  for (std::size_t i = 0; i < fault_on_.size(); ++i) {
    const bool once = !traits(faults_.plan()[i].kind).uses.length;
    const bool on = once ? faults_.begun(i, now) : faults_.on(i, now);
    if (on == fault_on_[i]) continue;
    fault_on_[i] = on;
    begin_or_end(faults_.plan()[i], on, faults_.any(faults_.plan()[i].kind, now));
  }
}

/// `any`: this fault or another of its kind is on.
void SimRobot::begin_or_end(const Fault& fault, bool on, bool any) {
  const auto connect = [any](SimBus::Endpoint& end) {
    end.set_state(any ? hal::CanBusState::kBusOff : hal::CanBusState::kErrorActive);
  };
  switch (fault.kind) {
    case FaultKind::kBusOff:
      return connect(vision_end_);
    case FaultKind::kStallPan:
      return pan_.set_stalled(any);
    case FaultKind::kStallTilt:
      return tilt_.set_stalled(any);
    case FaultKind::kRebootPan:
      return pan_.reboot();
    case FaultKind::kRebootTilt:
      return tilt_.reboot();
    case FaultKind::kSilentPan:
      return pan_.set_silent(any);
    case FaultKind::kSilentTilt:
      return tilt_.set_silent(any);
    case FaultKind::kSilentControl:
      return connect(control_end_);
    case FaultKind::kRejectingControl:
      return control_.set_rejecting(any);
    case FaultKind::kRestartControl:
      if (on) control_.restart(fault.length);
      return;
    case FaultKind::kControlClockJump:
      return control_.put_clock_forward(fault.jump);
    default:
      return;  // frames on the bus, cameras and loops ask the schedule
  }
}

}  // namespace headway::sim
