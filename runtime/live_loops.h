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
#include "runtime/frame_loop.h"
#include "runtime/links.h"
#include "runtime/threads.h"

namespace headway::runtime {

struct LiveConfig {
  Duration period = seconds(0.005);      ///< of the bus loop
  Duration look_every = seconds(0.002);  ///< how often the frame loop looks for a new frame
  Duration rest_within =
      seconds(12);  ///< the bus loop goes on for so long at most to bring the robot to rest
  // A loop that has not gone round for so long hangs. A camera that is opened again may take the frame loop
  // several of the kernel's time-outs of 5 s each.
  Duration bus_hangs = seconds(0.5);
  Duration frames_hang = seconds(20);
};

/// Once started, `bus` and `frames` belong to the threads until stop() has returned.
class LiveLoops {
 public:
  LiveLoops(const LiveConfig& config, hal::Clock& clock, BusLoop& bus, FrameLoop& frames, Links& links)
      : config_(config), clock_(clock), bus_(bus), frames_(frames), links_(links) {}
  /// As stop().
  ~LiveLoops() { stop(); }

  /// Called in the frame loop's thread after each of its orders; ahead of start().
  void on_update(std::function<void()> updated) { updated_ = std::move(updated); }
  void start();
  /// Plans nothing more, lets the robot come to rest, then ends. True when the control computer says that it
  /// stands. May be called again.
  bool stop() noexcept;

  /// A loop has ended by itself: for what reason. The robot is being brought to rest; call stop().
  std::optional<std::string> failure() const;
  /// Which loop hangs, as of `now`, and for how long; nothing while both go round, or have been stopped.
  std::optional<std::string> hanging(Time now) const;
  /// Why the bus loop does not run as urgently as it should; empty when it does.
  std::string refusal() const;

 private:
  void run_bus(const std::atomic<bool>& stop);
  void run_frames(const std::atomic<bool>& stop);

  LiveConfig config_;
  hal::Clock& clock_;
  BusLoop& bus_;
  FrameLoop& frames_;
  Links& links_;
  std::function<void()> updated_;
  std::unique_ptr<Thread> bus_thread_, frame_thread_;
  std::atomic<bool> at_rest_{true};
  std::atomic<Time> bus_round_{Time{}}, frame_round_{Time{}};  ///< when each began its newest round
};

}  // namespace headway::runtime
