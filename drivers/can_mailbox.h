// Frames and counts between the bus loop and a thread that does the input and output of an adapter.
// Lock-free; nothing here waits or allocates.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/can_bus.h"
#include "hal/exchange.h"

namespace headway::drivers {

/// The bus loop sends and receives, one other thread takes and delivers; any thread may read state and stats.
/// At most kInFlight frames are under way between send() and settle(); then there is no room until one is
/// settled.
class CanMailbox {
 public:
  static constexpr std::size_t kInFlight = 10, kIncoming = 512;

  // The bus loop's side: as hal::CanBus.
  bool send(const hal::CanFrame& frame) noexcept {
    const bool is_classic = frame.id <= 0x7FF && frame.dlc <= 8;
    if (!is_classic || state() == hal::CanBusState::kGone ||
        under_way_.load(std::memory_order_acquire) >= kInFlight) {
      refused_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    under_way_.fetch_add(1, std::memory_order_relaxed);
    return outgoing_.push(frame);
  }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept {
    std::size_t n = 0;
    while (n < into.size() && incoming_.pop(into[n])) ++n;
    return n;
  }

  // The other thread's side.
  /// The oldest frame that waits to be sent; settle() once it is on the bus or given up.
  bool take(hal::CanFrame& frame) noexcept { return outgoing_.pop(frame); }
  void settle(bool was_sent) noexcept {
    if (was_sent) sent_.fetch_add(1, std::memory_order_relaxed);
    under_way_.fetch_sub(1, std::memory_order_release);
  }
  /// Gives up what waits: it would be sent late.
  void discard_outgoing() noexcept {
    for (hal::CanFrame stale; take(stale);) settle(false);
  }
  void deliver(const hal::CanFrame& frame) noexcept {
    received_.fetch_add(1, std::memory_order_relaxed);
    incoming_.push(frame);
  }
  void count_lost() noexcept { lost_.fetch_add(1, std::memory_order_relaxed); }
  void count_unusable() noexcept { unusable_.fetch_add(1, std::memory_order_relaxed); }
  /// Counts each time that the bus goes off or away.
  void set_state(hal::CanBusState next, std::uint8_t transmit_errors = 0,
                 std::uint8_t receive_errors = 0) noexcept {
    const hal::CanBusState before = state_.exchange(next, std::memory_order_release);
    transmit_errors_.store(transmit_errors, std::memory_order_relaxed);
    receive_errors_.store(receive_errors, std::memory_order_relaxed);
    if (next == before) return;
    if (next == hal::CanBusState::kBusOff) bus_off_.fetch_add(1, std::memory_order_relaxed);
    if (next == hal::CanBusState::kGone) gone_.fetch_add(1, std::memory_order_relaxed);
  }

  // Any thread's.
  hal::CanBusState state() const noexcept { return state_.load(std::memory_order_acquire); }
  hal::CanBusStats stats() const noexcept {
    return {.state = state(),
            .transmit_errors = transmit_errors_.load(std::memory_order_relaxed),
            .receive_errors = receive_errors_.load(std::memory_order_relaxed),
            .sent = sent_.load(std::memory_order_relaxed),
            .received = received_.load(std::memory_order_relaxed),
            .refused = refused_.load(std::memory_order_relaxed),
            .lost = lost_.load(std::memory_order_relaxed) + incoming_.dropped(),
            .unusable = unusable_.load(std::memory_order_relaxed),
            .bus_off = bus_off_.load(std::memory_order_relaxed),
            .gone = gone_.load(std::memory_order_relaxed)};
  }

 private:
  using Count = std::atomic<std::uint64_t>;
  hal::BoundedQueue<hal::CanFrame, kInFlight> outgoing_;
  hal::BoundedQueue<hal::CanFrame, kIncoming> incoming_;
  std::atomic<std::size_t> under_way_{0};
  std::atomic<hal::CanBusState> state_{hal::CanBusState::kErrorActive};
  std::atomic<std::uint8_t> transmit_errors_{0}, receive_errors_{0};
  Count sent_{0}, received_{0}, refused_{0}, lost_{0}, unusable_{0}, bus_off_{0}, gone_{0};
};

}  // namespace headway::drivers
