// The loops on a real clock, each on its thread; and how a run ends: the robot at rest before the bus falls
// silent.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hal/clock.h"
#include "runtime/bus_loop.h"
#include "runtime/cycle.h"
#include "runtime/frame_loop.h"
#include "runtime/links.h"
#include "runtime/page_faults.h"
#include "runtime/real_time.h"
#include "runtime/threads.h"

namespace headway::runtime {

struct LiveConfig {
  Duration period = seconds(0.005);  ///< of the bus loop
  CycleLimits missed;                ///< cycles of the bus loop that are borne
  RealTime real_time;
  Duration look_every = seconds(0.002);  ///< how often the frame loop looks for a new frame
  Duration rest_within =
      seconds(12);  ///< the bus loop goes on for so long at most to bring the robot to rest
  // A loop that has not gone round for so long hangs. A camera that is opened again may take the frame loop
  // several of the kernel's time-outs of 5 s each.
  Duration bus_hangs = seconds(0.5);
  Duration frames_hang = seconds(20);
  /// When asked to end, the frame loop has so long for the round that it is in: two of those time-outs, and
  /// less than a service manager waits.
  Duration frames_end_within = seconds(10);
};

/// How the loops have kept time so far.
struct LoopFigures {
  std::uint64_t missed = 0;  ///< cycles of the bus loop
  Spread bus_wake_up;        ///< how late its rounds began; its count is that of the rounds
  Spread bus_run;            ///< how long they took
  Spread frame_run;          ///< how long the frame loop's work on a frame took
  PageFaults bus_faults;     ///< of the bus loop's rounds; known when it has ended
};

/// Once started, `bus` and `frames` belong to the threads until stop() has returned; what a loop that was
/// left hanging uses stays its own.
class LiveLoops {
 public:
  LiveLoops(const LiveConfig& config, hal::Clock& clock, BusLoop& bus, FrameLoop& frames, Links& links)
      : config_(config), clock_(clock), bus_(bus), frames_(frames), links_(links) {}
  /// As stop(); waits for a loop that hangs for as long as it does.
  ~LiveLoops() { stop(); }

  /// Called in the frame loop's thread after each of its orders; ahead of start().
  void on_update(std::function<void()> updated) { updated_ = std::move(updated); }
  /// Throws InputError where the kernel refuses what is enforced.
  void start();
  /// Lets the robot come to rest, whatever the frame loop does, then ends. True when the control computer
  /// says that it stands. Waits for neither loop without end: see left_hanging(). May be called again.
  bool stop() noexcept;
  /// Which loop stop() did not wait for; empty when both have ended. The program must then end without taking
  /// anything away that the loop may still use.
  const char* left_hanging() const noexcept;

  /// A loop has ended by itself: for what reason. The robot is being brought to rest; call stop().
  std::optional<std::string> failure() const;
  /// Which loop hangs, as of `now`, and for how long; nothing while both go round, or have been stopped.
  std::optional<std::string> hanging(Time now) const;
  /// Why the bus loop does not run as urgently as it should; empty when it does.
  std::string refusal() const;
  /// At any time, from any thread but for the faults.
  CycleHealth bus_health() const noexcept { return bus_cycle_ ? bus_cycle_->health() : CycleHealth::kOnTime; }
  std::uint64_t bus_missed() const noexcept { return bus_cycle_ ? bus_cycle_->missed() : 0; }
  LoopFigures figures() const noexcept;

 private:
  void run_bus(const std::atomic<bool>& stop);
  void run_frames(const std::atomic<bool>& stop);
  bool ends(const Thread* thread, Time until) noexcept;

  LiveConfig config_;
  hal::Clock& clock_;
  BusLoop& bus_;
  FrameLoop& frames_;
  Links& links_;
  std::function<void()> updated_;
  std::unique_ptr<Cycle> bus_cycle_;
  Histogram frame_run_;
  PageFaults bus_faults_;
  std::atomic<bool> at_rest_{true};
  std::atomic<Time> bus_round_{Time{}}, frame_round_{Time{}};  ///< when each began its newest round
  std::unique_ptr<Thread> bus_thread_, frame_thread_;          ///< last: they end before what they use
};

}  // namespace headway::runtime
