// What a drive calls itself: device name, hardware and software version (CiA 301, objects 0x1008 to 0x100A).
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "drivers/sdo_text.h"
#include "hal/can_bus.h"

namespace headway::app {

/// Once start()ed it asks for one after the other. Not before the drive is set up: both use its SDO channel.
class DriveNames final : public hal::BusNode {
 public:
  DriveNames(hal::CanBus& bus, std::uint8_t node) noexcept : sdo_(bus, node) {}

  void start() noexcept;
  void receive(const hal::CanFrame& frame) noexcept override { sdo_.receive(frame); }
  void tick(Time now) noexcept override;

  /// "Servo 7, hardware B, software 1.2"; of what the drive does not say nothing. Empty: it says none of
  /// them.
  std::string text() const;

 private:
  drivers::SdoText sdo_;
  std::array<std::array<char, drivers::SdoText::kMost + 1>, 3> texts_{};  ///< each ends with a zero
  std::size_t next_ = 0;
  bool is_started_ = false;
};

}  // namespace headway::app
