// A head drive as a CANopen node that does what the standard says, or what a test wants instead. Its state
// machine is written out by hand, so that a mistake in hal/cia402.h does not hide itself.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "hal/bus_codec.h"
#include "hal/can_bus.h"

namespace headway::drivers::testing {

class ScriptedDrive {
 public:
  enum class State {
    kDisabled = 0x40,
    kReady = 0x21,
    kOn = 0x23,
    kEnabled = 0x27,
    kQuickStop = 0x07,
    kFault = 0x08
  };
  using Key = std::pair<std::uint16_t, std::uint8_t>;

  explicit ScriptedDrive(std::uint8_t its_node) : node(its_node) {}

  // What a test may turn.
  std::uint8_t node;
  bool mute_status = false, mute_position = false, mute_heartbeat = false, mute_sdo = false;
  bool never_acknowledges = false,  ///< set-points; nor follows cyclic ones
      knows_transition_16 = true, fault_is_permanent = false, stuck_switched_on = false;
  bool homed = true, never_finds_home = false;
  std::int32_t home_reads = 0;          ///< position, once it has found home after a second
  std::optional<Key> refuses, forgets;  ///< objects it aborts, or does not keep
  std::int32_t position = 0;            ///< [0.001 deg]
  State state = State::kDisabled;

  // What a test may look at.
  std::map<Key, std::uint32_t> objects;
  std::vector<Key> written;                  ///< in order
  std::vector<std::int32_t> set_points;      ///< taken on the rising edge of bit 4
  std::vector<std::int32_t> cyclic_targets;  ///< each that counted from a SYNC on
  std::int32_t largest_start = 0;            ///< of the first of these, from where the joint was
  std::int32_t largest_step = 0;            ///< of the others from the one before, for each period in between
  std::vector<std::uint16_t> controlwords;  ///< each time it changed
  std::vector<State> states;                ///< each time it changed
  int sdo_requests = 0;
  bool operational = false, halted = false;
  int homings = 0;  ///< begun
  std::int32_t target = 0;

  std::vector<hal::CanFrame> out;  ///< frames it sends

  void boot(Time now) {
    operational = false;
    objects.clear();
    become(State::kDisabled);
    controlword_ = 0;
    acknowledges_ = false;
    waiting_.reset();
    send(hal::bus::Heartbeat{.state = hal::bus::Heartbeat::State::kBootUp}.pack(0x700u + node), now);
  }
  void emergency(std::uint16_t code, Time now) {
    send(hal::bus::Emcy{.code = code}.pack(0x080u + node), now);
  }
  void fault() { become(State::kFault); }
  void quick_stop() { become(State::kQuickStop); }

  void receive(const hal::CanFrame& frame, Time now) {
    using namespace hal::bus;
    if (frame.id == 0x701) {
      master_heard_ = now;
    } else if (const auto nmt = Nmt::unpack(frame); nmt && (nmt->node == 0 || nmt->node == node)) {
      operational = nmt->command == Nmt::Command::kStart;
      if (!operational) waiting_.reset();
    } else if (frame.id == Sync::kId) {
      synced_at_ = now;
      if (waiting_) obey(*waiting_);
      waiting_.reset();
      report(now);
    } else if (frame.id == 0x600u + node) {
      answer(*SdoRequest::unpack(frame), now);
    } else if (frame.id == 0x200u + node && operational && is_mapped(0x1400, 0x1600, 0x60400010, 3)) {
      const bool on_sync = objects[{0x1400, 2}] == 1;
      waiting_ = DriveCommand::unpack(frame);
      if (!on_sync) obey(*std::exchange(waiting_, std::nullopt));
    }
  }

  void tick(Time now) {
    const std::int32_t step = mode_ == kCyclic ? 300 : 200;  // 60 and 40 deg/s at 5 ms
    if (never_acknowledges && mode_ == kCyclic) target = position;
    velocity_ = 0;
    const std::uint32_t patience = objects[{0x1016, 1}] & 0xFFFF;
    if (patience == 0) master_heard_.reset();
    if (master_heard_ && now - *master_heard_ > std::chrono::milliseconds(patience)) {
      master_heard_.reset();
      if (state == State::kEnabled) quick_stop();
    }
    if (homing_ > 0 && !halted && --homing_ == 0) find_home();
    if (state == State::kEnabled && !halted && mode_ != kHomingMode) {
      const std::int32_t move = std::clamp(target - position, -step, step);
      position += move;
      velocity_ = move * 200;
    }
    const std::uint32_t period = objects[{0x1017, 0}];
    if (period != 0 && !mute_heartbeat && now - heartbeat_at_ >= std::chrono::milliseconds(period)) {
      using S = hal::bus::Heartbeat::State;
      heartbeat_at_ = now;
      send(hal::bus::Heartbeat{.state = operational ? S::kOperational : S::kPreOperational}.pack(0x700u +
                                                                                                 node),
           now);
    }
  }

 private:
  void send(std::optional<hal::CanFrame> frame, Time now) {
    frame.value().stamp = now;
    out.push_back(*frame);
  }

  void become(State next) {
    if (next == state) return;
    state = next;
    follows_ = false;
    brakes_ = 10;
    states.push_back(next);
    if (next == State::kEnabled) target = position;
    homing_ = 0;
  }

  bool is_mapped(std::uint16_t communication, std::uint16_t mapping, std::uint32_t first,
                 std::uint32_t count) {
    return (objects[{communication, 1}] & 0x80000000) == 0 && objects[{mapping, 0}] == count &&
           objects[{mapping, 1}] == first;
  }

  void report(Time now) {
    if (!operational) return;
    if (state == State::kQuickStop && brakes_ > 0) --brakes_;
    if (!mute_status && is_mapped(0x1800, 0x1A00, 0x60410010, 2)) {
      const std::uint16_t reached = position == target ? 0x0400 : 0;
      const bool follows = mode_ == kCyclic && state == State::kEnabled && !never_acknowledges;
      const bool attained = mode_ == kHomingMode && homed;
      const std::uint16_t acknowledged = acknowledges_ || follows || attained ? 0x1000 : 0;
      const std::uint16_t error = mode_ == kHomingMode && lost_home_ ? 0x2000 : 0;
      send(hal::bus::DriveStatus{.statusword = static_cast<std::uint16_t>(static_cast<int>(state) | reached |
                                                                          acknowledged | error),
                                 .mode = mode_}
               .pack(0x180u + node),
           now);
    }
    if (!mute_position && is_mapped(0x1801, 0x1A01, 0x60640020, 2)) {
      send(
          hal::bus::DriveMotion{.position_deg = position * 1e-3, .velocity_deg_per_s = velocity_ * 1e-3}.pack(
              0x280u + node),
          now);
    }
  }

  void answer(const hal::bus::SdoRequest& request, Time now) {
    ++sdo_requests;
    if (mute_sdo) return;
    const Key key{request.index, request.subindex};
    hal::bus::SdoAnswer reply{.command = 0x60, .index = request.index, .subindex = request.subindex};
    if (key == refuses || (operational && request.index >= 0x1400 && request.index < 0x1B00)) {
      reply.command = 0x80;
      reply.data = 0x08000022;
    } else if (request.command == 0x40) {
      const std::uint8_t size = sizes_[key];
      reply.command = static_cast<std::uint8_t>(0x43 | ((4 - size) << 2));
      reply.data = key == forgets ? objects[key] + 1 : objects[key];
    } else {
      sizes_[key] = static_cast<std::uint8_t>(4 - ((request.command >> 2) & 3));
      objects[key] = request.data;
      written.push_back(key);
    }
    send(reply.pack(0x580u + node), now);
  }

  void obey(const hal::bus::DriveCommand& c) {
    const std::uint16_t before = controlword_;
    controlword_ = c.controlword;
    if (before != controlword_) controlwords.push_back(controlword_);
    mode_ = c.mode;
    move_state(before);
    halted = (c.controlword & 0x100) != 0;
    if ((c.controlword & 0x10) == 0) acknowledges_ = false;
    const auto said = static_cast<std::int32_t>(std::lround(c.target_deg * 1000));
    if (mode_ == kCyclic) {
      follow(said);
      return;
    }
    const bool rising = (c.controlword & 0x10) != 0 && (before & 0x10) == 0;
    if (mode_ == kHomingMode) {
      look_for_home(rising);
      return;
    }
    if (state == State::kEnabled && rising) {
      set_points.push_back(said);
      if (never_acknowledges) return;
      target = set_points.back();
      acknowledges_ = true;
    }
  }

  void look_for_home(bool rising) {
    if ((controlword_ & 0x10) == 0 || state != State::kEnabled) homing_ = 0;
    if (!rising || state != State::kEnabled) return;
    ++homings;
    homing_ = 200;
    lost_home_ = false;
  }
  void find_home() {
    lost_home_ = never_finds_home;
    homed = !never_finds_home;
    if (homed) target = position = home_reads;
  }

  void follow(std::int32_t said) {
    if (state != State::kEnabled || never_acknowledges) {
      follows_ = false;
      return;
    }
    cyclic_targets.push_back(said);
    if (follows_) {
      const auto periods = std::max(1L, std::lround(to_seconds(synced_at_ - target_at_) / 0.02));
      largest_step = std::max(largest_step, std::abs(said - target) / static_cast<std::int32_t>(periods));
    } else {
      largest_start = std::max(largest_start, std::abs(said - position));
    }
    follows_ = true;
    target = said;
    target_at_ = synced_at_;
  }

  void move_state(std::uint16_t before) {
    const int w = controlword_;
    if (state == State::kFault) {
      if ((w & 0x80) != 0 && (before & 0x80) == 0 && !fault_is_permanent) become(State::kDisabled);
    } else if ((w & 0x02) == 0) {
      become(State::kDisabled);  // 7, 9, 10, 12
    } else if ((w & 0x06) == 0x02) {
      become(state == State::kEnabled ? State::kQuickStop : State::kDisabled);  // 11
    } else if ((w & 0x07) == 0x06) {
      if (state != State::kQuickStop) become(State::kReady);  // 2, 6, 8
    } else if ((w & 0x0F) == 0x07) {
      if (state == State::kReady || state == State::kEnabled) become(State::kOn);  // 3, 5
    } else if ((w & 0x0F) == 0x0F) {
      const bool from_on = state == State::kOn && !stuck_switched_on;
      const bool from_stop = state == State::kQuickStop && knows_transition_16 && brakes_ == 0;
      if (from_on || from_stop) become(State::kEnabled);  // 4, 16
    }
  }

  static constexpr std::int8_t kCyclic = 8, kHomingMode = 6;

  std::map<Key, std::uint8_t> sizes_;
  std::optional<hal::bus::DriveCommand> waiting_;  ///< for the next SYNC
  std::uint16_t controlword_ = 0;
  std::int8_t mode_ = 0;
  std::int32_t velocity_ = 0;
  bool acknowledges_ = false, lost_home_ = false;
  int brakes_ = 0;        ///< times that a quick stop is told before it may be left
  bool follows_ = false;  ///< has taken a cyclic target, and may take the next
  Time synced_at_{}, target_at_{};
  int homing_ = 0;  ///< cycles left until it is at home
  Time heartbeat_at_{};
  std::optional<Time> master_heard_;  ///< while it watches for that
};

}  // namespace headway::drivers::testing
