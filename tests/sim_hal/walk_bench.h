// A control computer on a bus, and a hand-held master that speaks the messages of the contract to it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "hal/bus_codec.h"
#include "hal/bus_protection.h"
#include "sim_hal/control_computer.h"
#include "sim_hal/sim_bus.h"

namespace headway::sim {

namespace bus = hal::bus;

inline hal::Footstep forward_step(hal::Foot foot, double length = 0.2) {
  return {foot, {length, foot == hal::Foot::kLeft ? 0.19 : -0.19, 0}, 0, seconds(0.8)};
}

/// left, right, left, ...
inline std::vector<hal::Footstep> forward_steps(int count, double length = 0.2) {
  std::vector<hal::Footstep> steps;
  for (int i = 0; i < count; ++i) {
    const hal::Foot foot = i % 2 == 0 ? hal::Foot::kLeft : hal::Foot::kRight;
    steps.push_back(forward_step(foot, i + 1 == count ? 0 : length));
  }
  return steps;
}

class WalkMaster {
 public:
  explicit WalkMaster(hal::CanBus& end) : end_(end) {}

  void send_step(std::uint8_t session, std::uint32_t index, const hal::Footstep& step) {
    bus::StepCommand m;
    m.foot = step.foot == hal::Foot::kLeft ? bus::StepCommand::Foot::kLeft : bus::StepCommand::Foot::kRight;
    m.seq = static_cast<std::uint8_t>(index % 64);
    m.session = session;
    m.dx = step.landing.x;
    m.dy = step.landing.y;
    m.dtheta = step.landing.yaw;
    m.duration = to_seconds(step.duration);
    m.dz = step.dz;
    send(*m.pack(), step_out_);
  }
  void send_order(std::uint8_t session, std::uint32_t index, const hal::WalkOrder& order) {
    bus::WalkOrder m;
    m.kind = static_cast<bus::WalkOrder::Kind>(order.kind);
    m.seq = static_cast<std::uint8_t>(index % 64);
    m.session = session;
    m.x = order.x;
    m.y = order.y;
    m.theta = order.turn;
    send(*m.pack(), order_out_);
  }
  void send_control(std::uint8_t session, bus::WalkControl::Request request) {
    bus::WalkControl m;
    m.request = request;
    m.session = session;
    m.last_seq = last_seq;
    send(*m.pack(), control_out_);
  }
  void send(hal::CanFrame frame, bus::Protector& protector) {
    protector.protect(frame);
    last_sent = frame;
    end_.send(frame);
  }
  /// Reads what has come in.
  void listen() {
    std::array<hal::CanFrame, 16> some;
    while (const std::size_t n = end_.receive(some)) {
      for (std::size_t i = 0; i < n; ++i) {
        const hal::CanFrame& f = some[i];
        if (const auto m = bus::WalkStatus::unpack(f)) status = *m, ++statuses;
        if (const auto m = bus::ChestXY::unpack(f)) chest_xy.push_back(*m);
        if (const auto m = bus::ChestZRot::unpack(f)) chest_zrot.push_back(*m);
        if (const auto m = bus::ControlTime::unpack(f)) times.push_back(*m);
        if (f.id >= 0x130 && f.id <= 0x140) frames.push_back(f);
      }
    }
  }

  std::uint8_t last_seq = 63;  ///< that WalkControl tells
  bus::WalkStatus status;
  int statuses = 0;
  std::vector<bus::ChestXY> chest_xy;
  std::vector<bus::ChestZRot> chest_zrot;
  std::vector<bus::ControlTime> times;
  std::vector<hal::CanFrame> frames;
  hal::CanFrame last_sent;
  bus::Protector step_out_{bus::StepCommand::kDataId}, order_out_{bus::WalkOrder::kDataId},
      control_out_{bus::WalkControl::kDataId};

 private:
  hal::CanBus& end_;
};

class WalkBench {
 public:
  explicit WalkBench(const ControlComputerConfig& config = {}, const Pose2& start = {})
      : start_stance(hal::Stance::parallel(start, 0.19)),
        control(config, start_stance, control_end_, Time{}) {
    control_end_.listen(control);
  }

  using Request = bus::WalkControl::Request;

  /// One tick of 5 ms; WalkControl every 40 ms while `session` is not 0.
  void tick() {
    if (session != 0 && now >= next_control_) {
      master.send_control(session, request);
      next_control_ = now + seconds(0.04);
    }
    now += seconds(0.005);
    can.advance(now);
    control.tick(now);
    master.listen();
  }
  void run(double duration) {
    for (const Time end = now + seconds(duration); now < end;) tick();
  }
  void begin(std::uint8_t new_session) {
    session = new_session;
    request = Request::kWalk;
    next_control_ = now;
    run(0.03);
  }
  /// Hands over steps as they find room, until the robot stands again; false when that takes over two
  /// minutes.
  bool walk(const std::vector<hal::Footstep>& steps) {
    std::uint32_t sent = 0;
    for (int i = 0; i < 24000; ++i) {
      const auto status_now = control.status();
      const bool asked = status_now.accepted != hal::kNoStep || sent == 0;
      if (sent < steps.size() && asked && control.pattern().queue_free() > 4) {
        master.send_step(session, sent, steps[sent]);
        ++sent;
      }
      tick();
      if (sent == steps.size() && control.counters().accepted >= sent &&
          control.status().state == hal::WalkState::kStanding && control.pattern().started() > 0)
        return true;
    }
    return false;
  }

  SimBus can;

 private:
  SimBus::Endpoint &control_end_ = can.attach("control"), &master_end_ = can.attach("master");
  Time next_control_{};

 public:
  hal::Stance start_stance;
  ControlComputer control;
  WalkMaster master{master_end_};
  Time now{};
  std::uint8_t session = 0;
  Request request = Request::kNone;
};

}  // namespace headway::sim
