// Footsteps, or the orders that they are part of, to the control computer over plain CAN frames with counter
// and CRC (docs/bus.md), on any hal::CanBus.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/cadence.h"
#include "drivers/control_clock.h"
#include "hal/bus_codec.h"
#include "hal/bus_protection.h"
#include "hal/can_bus.h"
#include "hal/walker.h"

namespace headway::drivers {

struct WalkerConfig {
  Duration status_timeout = hal::bus::WalkStatus::kTimeout;  ///< then the walker is lost
  Duration chest_timeout = hal::bus::ChestXY::kTimeout;      ///< then there is no chest pose
  ControlClockConfig clock;
  Duration step_repeat = hal::bus::StepCommand::kRepeat;
  Duration control_cycle = hal::bus::WalkControl::kCycle;
};

/// Frames of the control computer that were not used, by reason.
struct WalkerCounts {
  std::uint32_t wrong_crc = 0, repeated = 0, wrong_sequence = 0;
  std::uint32_t lost = 0;        ///< frames that never came, told by the counter
  std::uint32_t undeclared = 0;  ///< rightly protected, but with values the contract does not know
};

/// Real-time safe. Steps travel one at a time: the next goes out when the one before is accepted, and none
/// before the control computer has taken up the session (status().session). A rejection, or a change of the
/// session on the other side, ends the session: what is queued is dropped and send() refuses.
///
/// An order travels when its first step is handed over and every step before is accepted. The other side
/// takes it up to LastSeq, which never goes beyond an order still unanswered: so the rest of an older order
/// cannot be walked in place of a newer one.
class CanWalker final : public hal::Walker {
 public:
  static constexpr std::size_t kSlots = 8;

  /// The bus must outlive the walker.
  explicit CanWalker(hal::CanBus& bus, const WalkerConfig& config = {}) noexcept;

  void receive(const hal::CanFrame& frame) noexcept override;
  void tick(Time now) noexcept override;
  /// Index 0 with another session (1..15) begins that session's steps; then 1, 2, ... Refused also when the
  /// step does not fit its frame, when the number is not the next, when it is part of an order and does not
  /// follow on the part before, and while the walker is lost.
  bool send(std::uint8_t session, const hal::NumberedStep& step) noexcept override;
  void control(hal::WalkRequest request, std::uint8_t session, Duration map_age) noexcept override;
  hal::WalkStatus status() const noexcept override { return status_; }
  hal::WalkerHealth health() const noexcept override { return health_; }
  hal::ChestSample chest() const noexcept override { return chest_; }
  std::optional<hal::ClockOffset> clock() const noexcept override { return clock_offset_; }

  /// Steps and orders handed over and not yet accepted.
  std::size_t unanswered() const noexcept { return queued_; }
  WalkerCounts counts() const noexcept;
  /// The control computer's clock was heard within the time-out.
  bool clock_is_synchronised() const noexcept { return clock_fresh_; }

 private:
  template <class Message>
  std::optional<Message> read(const hal::CanFrame& frame, hal::bus::ProtectionChecker& checker) noexcept;
  void hear(const hal::bus::WalkStatus& message, Time stamp) noexcept;
  void pair_halves() noexcept;
  void match_answer() noexcept;
  void end_session() noexcept;
  bool goes_on(const hal::PartOfOrder& part) const noexcept;
  void send_step(Time now) noexcept;
  std::optional<std::uint32_t> accepted() const noexcept;
  std::uint8_t last_released() const noexcept;
  void send_control(Time now) noexcept;
  void judge(Time now) noexcept;

  hal::CanBus& bus_;
  WalkerConfig config_;
  hal::bus::Protector step_protector_, order_protector_, control_protector_;
  hal::bus::ProtectionChecker status_checker_, xy_checker_, rotation_checker_, time_checker_;
  std::uint32_t undeclared_ = 0;

  hal::WalkStatus status_;
  hal::WalkerHealth health_ = hal::WalkerHealth::kStarting;
  std::optional<Time> status_heard_, chest_heard_;
  ControlClock clock_;
  std::optional<hal::ClockOffset> clock_offset_;
  bool clock_fresh_ = false;

  hal::ChestSample chest_;
  std::optional<hal::bus::ChestXY> xy_;
  std::optional<hal::bus::ChestZRot> rotation_;
  Time xy_stamp_{}, rotation_stamp_{};  ///< when the halves came

  // The steps and orders of one session that are not yet accepted, oldest first.
  struct Slot {
    std::uint32_t index = 0;  ///< of the step, or of the order's first
    hal::CanFrame frame;
    bool is_order() const noexcept { return frame.id == hal::bus::WalkOrder::kId; }
  };
  std::array<Slot, kSlots> slots_{};
  std::size_t first_slot_ = 0, queued_ = 0;
  std::uint8_t session_ = 0;
  std::uint32_t next_index_ = 0;          ///< number of the step that send() takes next
  bool taken_up_ = false;                 ///< the control computer has reported this session
  bool ended_ = false;                    ///< no more steps in this session
  std::optional<Time> step_sent_;         ///< when the oldest step last went out
  std::optional<hal::PartOfOrder> part_;  ///< that the step handed over last is

  hal::WalkRequest request_ = hal::WalkRequest::kNone;
  std::uint8_t control_session_ = 0;
  Duration map_age_{};
  bool control_changed_ = true;
  Cadence control_cadence_;
};

}  // namespace headway::drivers
