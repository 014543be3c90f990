// Rows of a recording from one thread to another, in buffers that are made once and used over and over.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hal/exchange.h"
#include "runtime/topics.h"

namespace headway::runtime {

/// One writer thread, one reader thread; neither waits. The writer allocates only for a row that is longer
/// than any before it in its slot.
template <std::size_t kSlots>
class RowQueue {
 public:
  struct Slot {
    Topic topic{};
    std::uint32_t sequence = 0;
    Time time{};
    std::uint64_t ticket = 0;  ///< the writer's, for the order among several queues
    std::vector<std::byte> bytes;
    Row row() const { return {topic, sequence, time, bytes}; }
  };

  explicit RowQueue(std::size_t reserve) {
    for (std::uint32_t i = 0; i < kSlots; ++i) {
      slots_[i].bytes.reserve(reserve);
      empty_.push(i);
    }
  }

  /// Writer: a slot to fill and hand over; null (and counted) when all are full.
  Slot* take_empty() {
    std::uint32_t i = 0;
    if (!empty_.pop(i)) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return nullptr;
    }
    slots_[i].bytes.clear();
    return &slots_[i];
  }
  void hand_over(const Slot* slot) { full_.push(static_cast<std::uint32_t>(slot - slots_.data())); }

  /// Reader: the oldest row, until drop_front(); null when there is none.
  const Slot* front() {
    std::uint32_t i = 0;
    if (!front_ && full_.pop(i)) front_ = i;
    return front_ ? &slots_[*front_] : nullptr;
  }
  void drop_front() {
    empty_.push(*front_);
    front_.reset();
  }
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  std::array<Slot, kSlots> slots_;
  hal::BoundedQueue<std::uint32_t, kSlots> empty_, full_;
  std::optional<std::uint32_t> front_;  ///< the reader's
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace headway::runtime
