#include "app/leave_head.h"

#include <array>

namespace headway::app {

void leave_head(drivers::Cia402Head& head, hal::CanBus& bus, hal::Clock& clock) noexcept {
  constexpr Duration kCycle = std::chrono::milliseconds(5), kLongest = std::chrono::seconds(1);
  std::array<hal::CanFrame, 32> frames;
  head.leave();
  for (const Time end = clock.now() + kLongest; !head.has_left() && clock.now() < end;
       clock.sleep_until(clock.now() + kCycle)) {
    while (const std::size_t count = bus.receive(frames))
      for (const hal::CanFrame& frame : std::span(frames).first(count)) head.receive(frame);
    head.tick(clock.now());
  }
}

}  // namespace headway::app
