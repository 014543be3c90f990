// A CAN bus without hardware: every frame takes its time on the wire, the lowest identifier goes first, and
// every other endpoint receives it. Time moves only when told to. Faults on demand.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/can_bus.h"

namespace headway::sim {

struct SimBusConfig {
  double bit_rate = 500e3;      ///< [bit/s]
  std::size_t send_queue = 64;  ///< frames an endpoint can hold for sending
  std::size_t receive_queue =
      512;  ///< frames an endpoint can hold for its reader; the newest is dropped when full

  void validate() const;
};

/// Time on the wire of a classic frame with `dlc` bytes, stuffed as badly as can be.
Duration frame_time(std::uint8_t dlc, double bit_rate);

class SimBus {
 public:
  struct Counters {
    std::uint64_t sent = 0;          ///< frames that were on the wire
    std::uint64_t send_refused = 0;  ///< no room, or off the bus
    std::uint64_t receive_lost = 0;  ///< the reader's queue was full
    std::uint64_t fault_dropped = 0, fault_delayed = 0, fault_corrupted = 0;
  };

  /// One participant. Real-time safe as hal::CanBus asks.
  class Endpoint final : public hal::CanBus {
   public:
    bool send(const hal::CanFrame& frame) noexcept override;
    std::size_t receive(std::span<hal::CanFrame> into) noexcept override;
    hal::CanBusState state() const noexcept override { return state_; }

    /// Hands every frame to `node` at the moment it is complete, instead of queueing it; what the node sends
    /// in answer competes for the wire from that moment on.
    void listen(hal::BusNode& node) { listener_ = &node; }
    /// kBusOff or kGone: neither sends nor receives until set back; what waited to be sent is lost.
    void set_state(hal::CanBusState state);
    const std::string& name() const { return name_; }

   private:
    friend class SimBus;
    struct Waiting {
      hal::CanFrame frame;
      Time queued{};
    };
    Endpoint(SimBus& bus, std::string name);
    bool off() const { return state_ == hal::CanBusState::kBusOff || state_ == hal::CanBusState::kGone; }
    void deliver(const hal::CanFrame& frame) noexcept;

    SimBus& bus_;
    std::string name_;
    hal::BusNode* listener_ = nullptr;
    hal::CanBusState state_ = hal::CanBusState::kErrorActive;
    std::vector<Waiting> out_;
    std::size_t out_first_ = 0, out_size_ = 0;
    std::vector<hal::CanFrame> in_;
    std::size_t in_first_ = 0, in_size_ = 0;
  };

  explicit SimBus(const SimBusConfig& config = {}, Time start = Time{});
  SimBus(const SimBus&) = delete;
  SimBus& operator=(const SimBus&) = delete;

  /// A new participant; lives as long as the bus.
  Endpoint& attach(std::string name);
  /// Delivers every frame whose last bit is on the wire by `now`.
  void advance(Time now);
  Time now() const { return now_; }
  const Counters& counters() const { return counters_; }

  // Faults. A frame is dropped, delayed or corrupted when the predicate says so (asked once per frame, in the
  // order of the wire; it may count). An empty predicate ends the fault.
  using Predicate = std::function<bool(const hal::CanFrame&)>;
  void drop_if(Predicate which) { drop_ = std::move(which); }
  /// By how long a frame comes late at all receivers; zero or less: in time.
  using Lateness = std::function<Duration(const hal::CanFrame&)>;
  void delay_by(Lateness how_long) { delay_ = std::move(how_long); }
  /// Which bit of a frame's data is turned over, 0 the lowest of the first byte, as a faulty gateway would:
  /// the receivers' controllers see nothing. Nothing, or a bit that the frame does not have: none.
  using TurnedBit = std::function<std::optional<unsigned>(const hal::CanFrame&)>;
  void corrupt_by(TurnedBit which) { corrupt_ = std::move(which); }

 private:
  struct Delayed {
    hal::CanFrame frame;
    const Endpoint* from;
    Time due{};
  };
  Endpoint* next_sender(Time& start);
  void transmit(Endpoint& from, Time end);
  void broadcast(hal::CanFrame frame, const Endpoint* from);

  SimBusConfig config_;
  Time now_{}, free_at_{};
  std::vector<std::unique_ptr<Endpoint>> endpoints_;
  std::vector<Delayed> delayed_;
  Counters counters_;
  Predicate drop_;
  TurnedBit corrupt_;
  Lateness delay_;
};

}  // namespace headway::sim
