// What the bus loop hands to the recorder, from within its cycle: nothing waits, allocates or throws.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "hal/can_bus.h"
#include "hal/clock.h"
#include "hal/exchange.h"
#include "runtime/bus_observer.h"
#include "runtime/topics.h"

namespace headway::runtime {

class BusTap final : public BusObserver {
 public:
  // In the bus loop's thread:
  void received(const hal::CanFrame& frame) noexcept { put({frame, frame.stamp, received_++, false}); }
  void sent(const hal::CanFrame& frame, Time now) noexcept { put({frame, now, sent_++, true}); }
  void reported(const BusReport& report) noexcept override { reports_.push(report); }
  void walked(const StepRecord& step) noexcept override { steps_.push(step); }

  // In the recorder's:
  /// Takes out all that is there: visit(row), and watch(report) for each report.
  void drain(const std::function<void(const Row&)>& visit,
             const std::function<void(const BusReport&)>& watch);
  /// The three counts that are its own.
  void count(recorded::Drops& drops) const;

 private:
  struct CanRow {
    hal::CanFrame frame;
    Time time{};
    std::uint32_t sequence = 0;
    bool sent = false;
  };
  void put(const CanRow& row) noexcept { can_.push(row); }

  hal::BoundedQueue<CanRow, 4096> can_;
  hal::BoundedQueue<BusReport, 256> reports_;
  hal::BoundedQueue<StepRecord, 64> steps_;
  std::uint32_t received_ = 0, sent_ = 0;              ///< the bus loop's
  std::uint32_t report_number_ = 0, step_number_ = 0;  ///< the recorder's
  std::vector<std::byte> bytes_;
};

/// A bus that shows the tap what travels on it. Both, and the clock, must outlive it.
class TappedBus final : public hal::CanBus {
 public:
  TappedBus(hal::CanBus& bus, BusTap& tap, const hal::Clock& clock) : bus_(bus), tap_(tap), clock_(clock) {}

  bool send(const hal::CanFrame& frame) noexcept override {
    const bool sent = bus_.send(frame);
    if (sent) tap_.sent(frame, clock_.now());
    return sent;
  }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override {
    const std::size_t count = bus_.receive(into);
    for (const hal::CanFrame& frame : into.first(count)) tap_.received(frame);
    return count;
  }
  hal::CanBusState state() const noexcept override { return bus_.state(); }
  hal::CanBusStats stats() const noexcept override { return bus_.stats(); }

 private:
  hal::CanBus& bus_;
  BusTap& tap_;
  const hal::Clock& clock_;
};

}  // namespace headway::runtime
