// The bus loop as `headway run` runs it, with its masters, on its own urgent thread. At the other end of the
// wire the simulated robot moves on an ordinary thread, on another processor and midway between the loop's
// cycles, as it would in another machine: the loop pays for what it does, not for the simulator.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>

#include "app/live_session.h"
#include "app/node_session.h"
#include "hal/exchange.h"
#include "tests/shut_eyes.h"

namespace headway::bench {

/// Both ends of a wire between two threads. Counts what the loop's thread takes from the heap.
class Wire final : public hal::CanBus {
 public:
  bool send(const hal::CanFrame& frame) noexcept override { return to_robot_.push(frame); }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override;
  hal::CanBusState state() const noexcept override { return hal::CanBusState::kErrorActive; }

  /// The other end: hands over what came, and takes what is sent.
  void exchange_with(hal::CanBus& robot);
  /// Calls of `new` from the loop's first look at the wire to its last.
  std::uint64_t heap_calls() const { return heap_last_ - heap_first_; }
  /// When the loop first looked at the wire; zero before. Of the system's monotonic clock.
  Time first_look() const noexcept { return first_look_; }

 private:
  hal::BoundedQueue<hal::CanFrame, 512> to_robot_, to_loop_;
  std::atomic<std::thread::id> loop_{};
  std::atomic<std::uint64_t> heap_first_{0}, heap_last_{0};
  std::atomic<Time> first_look_{Time{}};
};

/// Runs from its construction to stop(); the robot stands, its head's drives are led.
class LiveBus {
 public:
  /// Throws InputError where the kernel refuses what `real_time` enforces.
  LiveBus(const app::Robot& robot, const runtime::RealTime& real_time);
  ~LiveBus();

  struct Result {
    runtime::LoopFigures times;
    std::uint64_t heap_calls = 0;
  };
  /// Throws Error when head and control computer were not both up at the end: nothing was measured.
  Result stop();

 private:
  void move_robot(std::optional<int> bus_processor);

  hal::ScaledClock clock_{1};
  app::NodeSession node_;
  Wire wire_;
  test::ShutEyes eyes_;
  std::unique_ptr<app::LiveSession> session_;
  std::atomic<bool> over_{false};
  std::thread nodes_;
};

}  // namespace headway::bench
