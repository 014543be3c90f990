// Both loops stepped by one manual clock: the same results on every run, however fast the machine is. The
// time that a frame's work would take on the robot is charged to the clock.
#pragma once

#include <cstdint>
#include <functional>

#include "hal/clock.h"
#include "runtime/bus_loop.h"
#include "runtime/cycle.h"
#include "runtime/frame_loop.h"

namespace headway::runtime {

class Lockstep {
 public:
  struct Config {
    Duration period = seconds(0.005);  ///< of the bus loop
    StageTimes charge;                 ///< what each stage of a frame costs on the robot
    CycleLimits missed{};              ///< cycles of the bus loop that are borne
  };
  /// `world` moves everything outside the program to a time.
  Lockstep(const Config& config, hal::ManualClock& clock, std::function<void(Time)> world, BusLoop& bus,
           FrameLoop& frames)
      : config_(config),
        clock_(clock),
        world_(std::move(world)),
        bus_(bus),
        frames_(frames),
        cycle_(config.period, config.missed) {}

  /// Loops that find no processor time.
  struct Starved {
    bool bus = false, frames = false;
  };
  /// Asked in each period: what a starved loop would have done then, it does not do.
  void starve(std::function<Starved(Time)> when) { starved_ = std::move(when); }

  /// Cycles of the bus loop, for want of processor time.
  std::uint64_t missed() const { return cycle_.missed(); }

  /// One period: the world, the bus loop, and the frame loop when it is free.
  void step() {
    clock_.advance(config_.period);
    const Time now = clock_.now();
    world_(now);
    const Starved starved = starved_ ? starved_(now) : Starved{};
    if (!starved.bus) bus_.cycle(now, cycle_.begin(now));
    if (starved.frames) {
      done_at_ += config_.period;
      return;
    }
    if (busy_ && now >= done_at_) {
      frames_.publish();
      busy_ = false;
    }
    if (!busy_ && frames_.work(now)) {
      busy_ = true;
      done_at_ = now + frames_.charge(config_.charge);
    }
  }

 private:
  Config config_;
  hal::ManualClock& clock_;
  std::function<void(Time)> world_;
  std::function<Starved(Time)> starved_;
  BusLoop& bus_;
  FrameLoop& frames_;
  Cycle cycle_;
  bool busy_ = false;
  Time done_at_{};
};

}  // namespace headway::runtime
