// The control computer as docs/bus.md tells it, as far as a step master can see it; a test may bend it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/bus_codec.h"
#include "hal/bus_protection.h"
#include "hal/can_bus.h"

namespace headway::drivers::testing {

class ScriptedControl {
 public:
  using Status = hal::bus::WalkStatus;

  // What a test may turn.
  bool deaf = false;  ///< hears no step
  bool mute_status = false, mute_chest = false, mute_rotation = false, mute_time = false;
  bool spoil_status = false;            ///< one bit wrong in every status
  bool stick_counter = false;           ///< the same status again and again
  bool accepts = true;                  ///< else it leaves steps unanswered
  std::optional<std::uint8_t> rejects;  ///< this number...
  Status::RejectReason reason = Status::RejectReason::kReach;
  int queue_free = 8;
  Duration clock_apart = seconds(12.3456);  ///< our clock less its
  double chest_x = 0, yaw = 0, age = 0.004;

  // What a test may look at.
  std::vector<hal::bus::StepCommand> accepted;  ///< in order, each once
  std::vector<hal::bus::StepCommand> heard;     ///< every frame with a good CRC and a new counter
  std::vector<hal::bus::WalkOrder> orders;      ///< every one heard; a test answers
  std::vector<hal::bus::WalkControl> controls;
  std::vector<Time> heard_at, controls_at;
  int refused_frames = 0;
  Status status{.seq_executing = Status::kSeqExecutingNone, .seq_accepted = Status::kSeqAcceptedNone};

  std::vector<hal::CanFrame> out;

  void reboot() {
    status = {.seq_executing = Status::kSeqExecutingNone, .seq_accepted = Status::kSeqAcceptedNone};
    accepted.clear();
  }

  void receive(const hal::CanFrame& frame, Time now) {
    if (frame.id == hal::bus::StepCommand::kId && !deaf) {
      if (!is_usable(step_checker_.check(frame))) {
        ++refused_frames;
        return;
      }
      heard.push_back(*hal::bus::StepCommand::unpack(frame));
      heard_at.push_back(now);
      if (accepts) judge(heard.back());
    } else if (frame.id == hal::bus::WalkOrder::kId) {
      if (is_usable(order_checker_.check(frame))) orders.push_back(*hal::bus::WalkOrder::unpack(frame));
    } else if (frame.id == hal::bus::WalkControl::kId) {
      if (!is_usable(control_checker_.check(frame))) {
        ++refused_frames;
        return;
      }
      controls.push_back(*hal::bus::WalkControl::unpack(frame));
      controls_at.push_back(now);
      obey(controls.back());
    }
  }

  void tick(Time now) {
    if (now < next_) return;
    next_ = now + std::chrono::milliseconds(20);
    sample_ = static_cast<std::uint8_t>((sample_ + 1) % 16);
    status.queue_free = static_cast<std::uint8_t>(queue_free);
    if (!mute_status) send_status(now);
    if (!mute_chest) {
      send(hal::bus::ChestXY{.sample = sample_, .x = chest_x, .y = -1, .age = age}.pack(), xy_, now);
      if (!mute_rotation) {
        send(
            hal::bus::ChestZRot{.sample = sample_, .z = 0.9, .roll = 0.02, .pitch = -0.04, .yaw = yaw}.pack(),
            rotation_, now);
      }
    }
    if (!mute_time && ++cycles_ % 50 == 0) send(hal::bus::ControlTime{.ms = ms(now)}.pack(), time_, now);
  }

 private:
  std::uint32_t ms(Time now) const {
    return static_cast<std::uint32_t>((now - clock_apart).time_since_epoch() / std::chrono::milliseconds(1));
  }
  void send(std::optional<hal::CanFrame> frame, hal::bus::Protector& protector, Time now) {
    protector.protect(frame.value());
    frame->stamp = now;
    out.push_back(*frame);
  }
  void send_status(Time now) {
    if (stick_counter) status_ = stuck_;
    stuck_ = status_;
    send(status.pack(), status_, now);
    if (spoil_status) out.back().data[3] = static_cast<std::uint8_t>(out.back().data[3] ^ 0x10);
  }

  void obey(const hal::bus::WalkControl& c) {
    using Request = hal::bus::WalkControl::Request;
    const bool stands = status.state == Status::State::kStanding;
    if (stands && c.request == Request::kWalk && c.session != 0 && c.session != status.session) {
      reboot();
      status.session = c.session;
    }
  }

  void judge(const hal::bus::StepCommand& step) {
    const auto expected = static_cast<std::uint8_t>(accepted.size() % 64);
    if (step.session != status.session) return reject(step, Status::RejectReason::kSession);
    if (!accepted.empty() && step.seq == accepted.back().seq) return;  // acknowledged again
    if (step.seq == rejects) return reject(step, reason);
    if (queue_free == 0) return reject(step, Status::RejectReason::kFull);
    if (step.seq != expected) return reject(step, Status::RejectReason::kSequence);
    accepted.push_back(step);
    status.seq_accepted = step.seq;
  }
  void reject(const hal::bus::StepCommand& step, Status::RejectReason why) {
    status.seq_rejected = step.seq;
    status.reject_reason = why;
  }

  hal::bus::ProtectionChecker step_checker_{0x120}, order_checker_{0x122}, control_checker_{0x121};
  hal::bus::Protector status_{0x130}, xy_{0x131}, rotation_{0x132}, time_{0x140};
  hal::bus::Protector stuck_{0x130};
  std::uint8_t sample_ = 0;
  int cycles_ = 0;
  Time next_{};
};

}  // namespace headway::drivers::testing
