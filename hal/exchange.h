// How state crosses threads without locks: the newest value of something, and a bounded queue of events.
// Each has one writer thread and one reader thread; neither ever waits or allocates. `Atomic` is std::atomic:
// tests put one in its place that goes through every interleaving, and every value that the memory orders let
// a load see.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace headway::hal {

/// The newest value that a writer has published; values in between are lost on purpose. Three buffers: one
/// the writer fills, one the reader reads, one in the middle that changes hands in a single exchange.
template <class Value, template <class> class Atomic = std::atomic>
class NewestSlot {
 public:
  static_assert(std::is_copy_assignable_v<Value>);

  /// Writer: makes `value` the newest.
  void publish(const Value& value) noexcept(std::is_nothrow_copy_assignable_v<Value>) {
    buffers_[writing_] = value;
    const std::uint8_t old =
        middle_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel);
    writing_ = old & kIndex;
  }

  /// Reader: takes up what was published since; true when there was something new.
  bool update() noexcept {
    if (!(middle_.load(std::memory_order_relaxed) & kFresh)) return false;  // the exchange acquires
    const std::uint8_t old = middle_.exchange(reading_, std::memory_order_acq_rel);
    reading_ = old & kIndex;
    return true;
  }
  /// Reader: the value taken up last; default constructed before the first.
  const Value& value() const noexcept { return buffers_[reading_]; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;
  std::array<Value, 3> buffers_{};
  std::uint8_t writing_ = 0, reading_ = 1;
  Atomic<std::uint8_t> middle_{2};
};

/// Events in order. When full, new events are dropped and counted: the reader is late, not the writer.
template <class Event, std::size_t kCapacity, template <class> class Atomic = std::atomic>
class BoundedQueue {
 public:
  /// Writer: false (and counted) when there was no room.
  bool push(const Event& event) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    const std::size_t next = (tail + 1) % kSlots;
    if (next == head_.load(std::memory_order_acquire)) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[tail] = event;
    tail_.store(next, std::memory_order_release);
    return true;
  }
  /// Reader: false when empty.
  bool pop(Event& event) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    event = slots_[head];
    head_.store((head + 1) % kSlots, std::memory_order_release);
    return true;
  }
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kSlots = kCapacity + 1;
  std::array<Event, kSlots> slots_{};
  Atomic<std::size_t> head_{0}, tail_{0};
  Atomic<std::uint64_t> dropped_{0};
};

}  // namespace headway::hal
