// The walking robot behind the control computer: takes footsteps, reports what it does and where its chest
// is.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "hal/can_bus.h"
#include "hal/clock_offset.h"
#include "hal/footstep.h"
#include "hal/time.h"
#include "hal/walk_order.h"

namespace headway::hal {

/// As WalkControl.Request in config/can/headway.dbc.
enum class WalkRequest : std::uint8_t { kNone = 0, kWalk = 1, kSmoothStop = 2, kAbort = 3 };

/// As WalkStatus.State.
enum class WalkState : std::uint8_t {
  kStanding = 0,  ///< at rest, feet on the floor
  kWalking = 1,   ///< executing steps
  kStopping = 2,  ///< taking its last steps, or settling
  kFault = 3,     ///< cannot walk (fallen, drives off)
};

/// As WalkStatus.RejectReason.
enum class StepReject : std::uint8_t {
  kNone = 0,
  kSession = 1,   ///< of another walk
  kSequence = 2,  ///< not the next number
  kLate = 3,      ///< after its deadline
  kReach = 4,     ///< beyond the stride limits
  kFull = 5,      ///< no room in the queue
  kState = 6,     ///< not in a state to walk
};

/// Sequence numbers on the wire: 0..63, then again from 0. kNoStep: none yet in this session.
constexpr std::uint8_t kNoStep = 255;

struct WalkStatus {
  WalkState state = WalkState::kStanding;
  std::uint8_t session = 0;          ///< 0..15, the walk it has taken up
  std::uint8_t executing = kNoStep;  ///< number of the step under way (the last one, once standing)
  std::uint8_t accepted = kNoStep;   ///< the newest number accepted
  std::uint8_t rejected = kNoStep;   ///< the newest number rejected (meaningful with a reason)
  StepReject reject_reason = StepReject::kNone;
  int queue_free = 0;
  Duration phase_remaining{};  ///< until the step under way ends
  Time stamp{};                ///< when the frame came
};

/// A step with its number within the session's walk (0, 1, 2, ...; the wire carries it modulo 64).
struct NumberedStep {
  std::uint32_t index = 0;
  Footstep step;
  std::optional<PartOfOrder> order{};  ///< that it is part of; nothing when the step itself travels
};

enum class WalkerHealth : std::uint8_t {
  kStarting,  ///< nothing heard yet
  kReady,     ///< status and chest pose arrive in time
  kNoChest,   ///< the chest pose stayed away 100 ms: mapping pauses
  kLost,      ///< the status stayed away 100 ms: no step can be committed
};

struct ChestSample {
  Time stamp{};  ///< when the pose held
  Eigen::Isometry3d odom_from_chest = Eigen::Isometry3d::Identity();
};

/// Speaks footsteps to the control computer. Real-time safe.
class Walker : public BusNode {
 public:
  /// Hands over one committed step of the session; repeated on the wire until accepted or rejected. False,
  /// and nothing done, while the step before is still unanswered and its slots are full. Of an order's steps
  /// the first sends the order, the others release the next step of it.
  virtual bool send(std::uint8_t session, const NumberedStep& step) noexcept = 0;
  /// What is asked of the walk from now on, and the age of the map it rests on (cyclic on the wire).
  virtual void control(WalkRequest request, std::uint8_t session, Duration map_age) noexcept = 0;
  virtual WalkStatus status() const noexcept = 0;
  virtual WalkerHealth health() const noexcept = 0;
  /// The newest complete chest pose; its stamp tells whether it is new.
  virtual ChestSample chest() const noexcept = 0;
  /// The control computer's clock, as of the last tick; nothing while it is not known.
  virtual std::optional<ClockOffset> clock() const noexcept { return std::nullopt; }
};

}  // namespace headway::hal
