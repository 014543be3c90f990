#include "drivers/homing.h"

#include "hal/cia402.h"

namespace headway::drivers {

namespace status_bit = hal::cia402::status_bit;

void Homing::tick(std::optional<std::uint16_t> statusword, bool paused, Time now) noexcept {
  const auto says = [&](std::uint16_t bit) { return statusword && (*statusword & bit) != 0; };
  if (!paused) spent_ += now - ticked_;
  ticked_ = now;
  switch (status_) {
    case Status::kAsked:
      if (!statusword) break;
      spent_ = Duration{};
      status_ = says(status_bit::kHomingAttained) ? Status::kDone
                : may_move_                       ? Status::kMoving
                                                  : Status::kNotHomed;
      may_move_ = false;
      break;
    case Status::kMoving:
      if (says(status_bit::kHomingError) || spent_ > numbers_->longest)
        status_ = Status::kFailed;
      else if (says(status_bit::kHomingAttained) && says(status_bit::kTargetReached))
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
