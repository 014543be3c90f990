#include "drivers/homing.h"

#include "hal/cia402.h"

namespace headway::drivers {

namespace status_bit = hal::cia402::status_bit;

void Homing::tick(std::uint16_t statusword, Time now) noexcept {
  const bool attained = (statusword & status_bit::kHomingAttained) != 0;
  switch (status_) {
    case Status::kAsked:
      status_ = attained ? Status::kDone : numbers_->may_move ? Status::kMoving : Status::kNotHomed;
      began_ = now;
      break;
    case Status::kMoving:
      if ((statusword & status_bit::kHomingError) != 0 || now - began_ > numbers_->longest)
        status_ = Status::kFailed;
      else if (attained && (statusword & status_bit::kTargetReached) != 0)
        status_ = Status::kDone;
      break;
    case Status::kDone:
    case Status::kNotHomed:
    case Status::kFailed:
      break;
  }
}

std::uint16_t Homing::bits() const noexcept {
  return status_ == Status::kMoving ? hal::cia402::control_bit::kStartHoming : std::uint16_t{0};
}

}  // namespace headway::drivers
