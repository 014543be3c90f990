// A bus, a head and a control computer for the bus loop, each as simple as can be.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "hal/can_bus.h"
#include "hal/head.h"
#include "hal/walker.h"

namespace headway::runtime {

class SilentBus final : public hal::CanBus {
 public:
  bool send(const hal::CanFrame&) noexcept override { return true; }
  std::size_t receive(std::span<hal::CanFrame>) noexcept override { return 0; }
  hal::CanBusState state() const noexcept override { return is; }

  hal::CanBusState is = hal::CanBusState::kErrorActive;
};

class FakeHead final : public hal::Head {
 public:
  void receive(const hal::CanFrame&) noexcept override {}
  void tick(Time now) noexcept override {
    if (!silent) state_.stamp = now;
  }
  void command(const hal::HeadAngles& target) noexcept override { state_.target = state_.position = target; }
  hal::HeadState state() const noexcept override {
    hal::HeadState state = state_;
    state.health = health;
    return state;
  }
  void recover() noexcept override { ++recovered; }

  hal::HeadHealth health = hal::HeadHealth::kReady;
  bool silent = false;  ///< tells no more where it is
  int recovered = 0;    ///< times it was told to

 private:
  hal::HeadState state_;
};

/// A control computer that shifts its weight for 1.3 s, takes 0.8 s for each step, accepts it unless told to
/// refuse, and has its chest one metre above the place between the feet that landed last.
class FakeWalker final : public hal::Walker {
 public:
  void receive(const hal::CanFrame&) noexcept override {}
  void tick(Time now) noexcept override {
    walk(now);
    if (silent) return;
    heard_ = status_;
    heard_.stamp = now;
    if (fault) heard_.state = hal::WalkState::kFault;
    heard_chest_ = chest_;
    heard_chest_.stamp = now;
  }
  /// Switched off and on: it stands where it is, and knows of no walk.
  void restart() {
    status_ = {};
    steps_ = started_ = 0;
  }
  /// As it truly is.
  bool stands() const { return status_.state == hal::WalkState::kStanding; }
  bool send(std::uint8_t session, const hal::NumberedStep& step) noexcept override {
    if (session != status_.session) return false;
    if (sent_count < sent.size()) sent[sent_count++] = step;
    if (step.index == refused) {
      status_.rejected = static_cast<std::uint8_t>(step.index % 64);
      status_.reject_reason = hal::StepReject::kReach;
      return true;
    }
    if (status_.reject_reason != hal::StepReject::kNone) return true;
    coming_[step.index % coming_.size()] = step.step;
    status_.accepted = static_cast<std::uint8_t>(step.index % 64);
    ++steps_;
    return true;
  }
  void control(hal::WalkRequest request, std::uint8_t session, Duration) noexcept override {
    request_ = request;
    session_ = session;
  }
  hal::WalkStatus status() const noexcept override { return heard_; }
  hal::WalkerHealth health() const noexcept override { return hal::WalkerHealth::kReady; }
  hal::ChestSample chest() const noexcept override { return heard_chest_; }
  std::optional<hal::ClockOffset> clock() const noexcept override { return apart; }

  std::optional<hal::ClockOffset> apart;
  std::array<hal::NumberedStep, 64> sent{};
  std::size_t sent_count = 0;
  std::uint32_t refused = 1000000;  ///< number of the step that it refuses
  bool deaf = false;                ///< takes up no other walk
  bool silent = false;              ///< walks what it has, and nothing is heard of it
  bool fault = false;               ///< says so
  hal::Stance stance = hal::Stance::parallel({}, 0.19);

 private:
  void walk(Time now) {
    if (!deaf && request_ == hal::WalkRequest::kWalk && status_.state == hal::WalkState::kStanding &&
        session_ != status_.session) {
      status_.session = session_;
      status_.accepted = status_.executing = hal::kNoStep;
      status_.reject_reason = hal::StepReject::kNone;
      steps_ = 0;
      started_ = 0;
    }
    if (steps_ > started_ && status_.state == hal::WalkState::kStanding && started_ == 0) begin_step(now);
    if (status_.state == hal::WalkState::kWalking) {
      if (now >= ends_) {
        stance = stance.after(coming_[(started_ - 1) % coming_.size()]);
        chest_.odom_from_chest = stance.base().lifted(1.0);
        if (steps_ > started_)
          begin_step(now);
        else
          status_.state = hal::WalkState::kStanding;
      }
      status_.phase_remaining = std::max(Duration(0), Duration(ends_ - now));
    }
  }
  void begin_step(Time now) {
    status_.state = hal::WalkState::kWalking;
    ends_ = now + seconds(started_ == 0 ? 1.3 + 0.8 : 0.8);
    status_.executing = static_cast<std::uint8_t>(started_++ % 64);
  }
  hal::WalkStatus status_, heard_;
  hal::ChestSample chest_{{}, Pose2{}.lifted(1.0)}, heard_chest_{chest_};
  std::array<hal::Footstep, 8> coming_{};
  hal::WalkRequest request_ = hal::WalkRequest::kNone;
  std::uint8_t session_ = 0;
  std::uint32_t steps_ = 0, started_ = 0;
  Time ends_{};
};

}  // namespace headway::runtime
