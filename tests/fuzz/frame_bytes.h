// Any bytes as what travels on the robot's bus: what fuzzers and mutation tests throw at the codec, at who
// decodes frames for people, and at the walker, whom somebody meanwhile hands steps; and small rows to begin
// with.
#pragma once

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/can_decoder.h"
#include "drivers/can_walker.h"
#include "hal/bus_codec.h"
#include "hal/bus_protection.h"
#include "hal/step_number.h"
#include "tests/fuzz/any_bytes.h"
#include "tests/fuzz/heard_bus.h"
#include "tests/fuzz/promise.h"

namespace headway::fuzz {

/// What a frame says must travel back: packed and read anew it is the same.
inline void read_and_pack(const hal::CanFrame& frame) {
  std::array<double, 16> values{}, again{};
  if (!hal::bus::unpack_values(frame, values)) return;
  const std::size_t count = hal::bus::find_message(frame.id)->signals.size();
  const auto packed = hal::bus::pack_values(frame.id, std::span(values).first(count));
  promise(packed && packed->dlc == frame.dlc && hal::bus::unpack_values(*packed, again) && values == again,
          "what is read of a frame can be packed, and reads the same");
}

/// One row: each record begins with a byte that says what it is (its lower two bits) and how much time has
/// passed.
class FrameRow {
 public:
  enum Record : std::uint8_t { kAsItIs, kProtected, kRightCrc, kOrder };

  explicit FrameRow(std::string_view input) : bytes_(input) {}

  void run() {
    while (!bytes_.empty()) step();
  }

 private:
  void step() {
    const std::uint8_t what = bytes_.byte();
    const int time = what >> 2;
    now_ += std::chrono::milliseconds(time * time);
    if (what % 4 == kOrder)
      order();
    else
      hear(frame(static_cast<Record>(what % 4)));
    bus_.full = time == 63;
    bus_.sent.clear();
    walker_.tick(now_);
    look_at_walker();
    look_at_what_was_sent();
  }

  /// Known identifiers mostly, and their length; a frame may be heard a little late.
  hal::CanFrame frame(Record record) {
    const std::uint8_t which = bytes_.byte(), length = bytes_.byte();
    const auto known = hal::bus::messages();
    hal::CanFrame f;
    f.id = which < 128 ? known[which % known.size()].id : bytes_.word() & 0x7FFU;
    const hal::bus::MessageInfo* message = hal::bus::find_message(f.id);
    f.dlc = length % 16 <= 8 ? length % 16 : message ? message->dlc : std::uint8_t{8};
    f.data = bytes_.data();
    f.stamp = now_ - std::chrono::milliseconds(length / 16);
    if (!message || message->data_id == 0) return f;
    if (record == kProtected) protectors_.try_emplace(f.id, message->data_id).first->second.protect(f);
    if (record == kRightCrc) f.data[0] = hal::bus::frame_crc(f, message->data_id);
    return f;
  }

  void hear(const hal::CanFrame& frame) {
    read_and_pack(frame);
    decode(frame);
    walker_.receive(frame);
  }

  void decode(const hal::CanFrame& frame) {
    const app::DecodedFrame decoded = decoder_.decode(frame);
    promise(is_plain_text(decoded.name) && is_plain_text(decoded.canopen.function), "names are plain text");
    promise(decoded.canopen.node >= 0 && decoded.canopen.node < 128, "nodes are CANopen's");
    promise(decoded.declared || decoded.signals.empty(), "undeclared frames have no values");
    promise(!decoded.check || is_plain_text(app::name_of(*decoded.check)), "each verdict has a name");
    for (const app::SignalValue& s : decoded.signals)
      promise(std::isfinite(s.value) && is_plain_text(s.name) && is_plain_text(s.unit) &&
                  is_plain_text(s.meaning) && !s.name.empty() && (s.hex_digits == 0 || s.value >= 0),
              "values can be shown", s.name);
    const app::DecodedCounts c = decoder_.counts();
    promise(c.frames == ++decoded_ && c.unknown + c.undeclared <= c.frames &&
                c.wrong_crc + c.repeated + c.wrong_sequence <= c.frames,
            "each frame is counted once");
  }

  /// Somebody asks for a walk, or hands over a step or a part of an order.
  void order() {
    const std::uint8_t what = bytes_.byte(), session = bytes_.byte() % 18;
    if (what % 2 == 0) {
      walker_.control(static_cast<hal::WalkRequest>(what / 2 % 4), session,
                      std::chrono::milliseconds(bytes_.number()));
      return;
    }
    hal::NumberedStep step{.index = what >= 192 ? bytes_.byte() : next_, .step = {}, .order = {}};
    step.step.foot = what & 2 ? hal::Foot::kRight : hal::Foot::kLeft;
    step.step.landing = {1e-3 * bytes_.number(), 1e-3 * bytes_.number(), 1e-3 * bytes_.number()};
    step.step.dz = 1e-3 * static_cast<std::int8_t>(bytes_.byte());
    step.step.duration = std::chrono::milliseconds(10 * bytes_.byte());
    step.step.clear = 1e-3 * bytes_.byte();
    if (what & 4)
      step.order = {{static_cast<hal::WalkOrder::Kind>(what / 8 % 3), step.step.landing.x,
                     step.step.landing.y, step.step.landing.yaw},
                    bytes_.byte()};
    if (walker_.send(session, step)) next_ = step.index + 1;
    if (what & 128) next_ = 0;  // a new session, perhaps
  }

  void look_at_walker() {
    using hal::WalkerHealth;
    const WalkerHealth health = walker_.health();
    const hal::WalkStatus status = walker_.status();
    promise(health <= WalkerHealth::kLost, "the walker's health has a name");
    promise(status.state <= hal::WalkState::kFault && status.reject_reason <= hal::StepReject::kState &&
                status.session <= hal::kLastSession && status.queue_free >= 0 && status.queue_free <= 15 &&
                status.phase_remaining >= Duration{},
            "the status is one that the contract knows");
    const bool fresh = now_ - status.stamp <= hal::bus::WalkStatus::kTimeout;
    promise(fresh || health == WalkerHealth::kStarting || health == WalkerHealth::kLost,
            "a walker without status is lost");
    promise(walker_.unanswered() <= drivers::CanWalker::kSlots, "slots do not overflow");
    look_at_chest();
    if (const auto clock = walker_.clock())
      promise(clock->uncertainty >= Duration{}, "a clock is known with an uncertainty");
    const drivers::WalkerCounts c = walker_.counts();
    promise(c.wrong_crc >= counts_.wrong_crc && c.repeated >= counts_.repeated &&
                c.wrong_sequence >= counts_.wrong_sequence && c.lost >= counts_.lost &&
                c.undeclared >= counts_.undeclared,
            "counts only grow");
    counts_ = c;
  }

  void look_at_chest() {
    const hal::ChestSample chest = walker_.chest();
    const Eigen::Matrix3d turn = chest.odom_from_chest.linear();
    promise(chest.stamp >= chest_ && chest.stamp <= now_, "the chest's poses follow each other, up to now");
    promise(chest.odom_from_chest.translation().allFinite() &&
                (turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9 &&
                turn.determinant() > 0,
            "the chest's pose is one");
    chest_ = chest.stamp;
  }

  void look_at_what_was_sent() {
    std::array<double, 16> values{};
    for (const hal::CanFrame& frame : bus_.sent) {
      const auto checker = checkers_.find(frame.id);
      promise(checker != checkers_.end(), "the walker sends its own messages");
      promise(checker->second.check(frame) == hal::bus::Check::kOk,
              "each with the next counter, and the right CRC");
      promise(hal::bus::unpack_values(frame, values), "each as the contract declares it");
      promise(frame.id == hal::bus::WalkControl::kId || walker_.health() == hal::WalkerHealth::kReady ||
                  walker_.health() == hal::WalkerHealth::kNoChest,
              "no step is sent without status");
    }
  }

  AnyBytes bytes_;
  Time now_ = at_seconds(1000), chest_{};
  HeardBus bus_;
  drivers::CanWalker walker_{bus_};
  drivers::WalkerCounts counts_;
  app::CanDecoder decoder_;
  std::uint64_t decoded_ = 0;
  std::uint32_t next_ = 0;  ///< number of the step to hand over
  std::map<std::uint32_t, hal::bus::Protector> protectors_;
  std::map<std::uint32_t, hal::bus::ProtectionChecker> checkers_{
      {hal::bus::StepCommand::kId, hal::bus::ProtectionChecker(hal::bus::StepCommand::kDataId)},
      {hal::bus::WalkControl::kId, hal::bus::ProtectionChecker(hal::bus::WalkControl::kDataId)},
      {hal::bus::WalkOrder::kId, hal::bus::ProtectionChecker(hal::bus::WalkOrder::kDataId)}};
};

inline void hear_frames(std::string_view input) { FrameRow(input).run(); }

/// `frame` heard after `time`^2 milliseconds.
inline void put(Input& row, FrameRow::Record record, int time, const hal::CanFrame& frame) {
  const auto known = hal::bus::messages();
  std::size_t which = 0;
  while (known[which].id != frame.id) ++which;
  row.byte(record | time << 2).byte(static_cast<int>(which)).byte(frame.dlc).data(frame.data);
}

inline std::vector<std::string> whole_frame_rows() {
  namespace bus = hal::bus;
  Input walk, clock, all;
  const auto status = [&](bus::WalkStatus s) { put(walk, FrameRow::kProtected, 4, *s.pack()); };
  const auto chest = [&](std::uint8_t sample) {
    put(walk, FrameRow::kProtected, 1, *bus::ChestXY{.sample = sample, .x = 1, .age = 0.004}.pack());
    put(walk, FrameRow::kProtected, 1, *bus::ChestZRot{.sample = sample, .z = 0.9, .yaw = 0.5}.pack());
  };
  bus::WalkStatus s{.seq_executing = 255, .seq_accepted = 255, .queue_free = 8};
  status(s);
  chest(1);
  walk.byte(FrameRow::kOrder).byte(2).byte(1).word(100);  // walk, session 1
  s.session = 1;
  for (int i = 0; i < 3; ++i) {
    walk.byte(FrameRow::kOrder).byte(i % 2 ? 3 : 1).byte(1).word(200).word(i % 2 ? -190 : 190).word(0);
    walk.byte(0).byte(80).byte(0);
    status(s);
    s.seq_accepted = static_cast<std::uint8_t>(i);
    status(s);
    chest(static_cast<std::uint8_t>(i + 2));
  }
  walk.byte(FrameRow::kOrder).byte(5).byte(1).word(2000).word(0).word(0).byte(0).byte(80).byte(0).byte(0);
  s.reject_reason = bus::WalkStatus::RejectReason::kReach;
  s.seq_rejected = 3;
  status(s);
  for (std::uint32_t ms = 0; ms < 5; ++ms)
    put(clock, FrameRow::kProtected, 32, *bus::ControlTime{.ms = 0xFFFFF000 + 1024 * ms}.pack());
  put(clock, FrameRow::kRightCrc, 50, *bus::ControlTime{.counter = 3, .ms = 7}.pack());
  for (const bus::MessageInfo& message : bus::messages())
    put(all, FrameRow::kAsItIs, 2, {.id = message.id, .dlc = message.dlc, .data = {1, 2, 3}, .stamp = {}});
  return {walk.text(), clock.text(), all.text()};
}

}  // namespace headway::fuzz
