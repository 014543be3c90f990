// A CAN bus behind a serial adapter that speaks Lawicel's protocol (CANUSB, CANable with slcan firmware). It
// comes back by itself when the adapter is plugged in again.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "drivers/back_off.h"
#include "drivers/slcan_protocol.h"
#include "hal/can_bus.h"
#include "hal/clock.h"

namespace headway::drivers {

struct SlcanConfig {
  std::string path{};               ///< of the tty; a name that stays, as under /dev/serial/by-id
  int bit_rate = hal::kCanBitRate;  ///< of the bus [bit/s]: one of those that the protocol knows
  int baud_rate = 115'200;          ///< of the line; adapters on USB pass over it
  BackOffConfig retry{};            ///< of opening an adapter that went away

  /// Throws InputError.
  void validate() const;
};

/// send(), receive(), state() and stats() belong to the bus loop and are real-time safe. serve() belongs to
/// one thread that may wait, for opening a tty may: without it a lost adapter stays lost.
///
/// The protocol tells nothing of the controller: state() is kErrorActive, or kGone. An adapter that refuses
/// many commands one after the other is given up as gone, and opened anew. `refused` counts its refusals,
/// too. Frames are stamped when they are read.
class SlcanBus final : public hal::CanBus {
 public:
  /// Opens the tty and tells the adapter to go on the bus. Whether that did is not waited for: some adapters
  /// never answer. Throws InputError where the configuration or the tty is wrong. The clock must outlive the
  /// bus.
  SlcanBus(const SlcanConfig& config, hal::Clock& clock);
  /// Takes the adapter off the bus.
  ~SlcanBus() override;
  SlcanBus(const SlcanBus&) = delete;
  SlcanBus& operator=(const SlcanBus&) = delete;

  /// False when the tty has no room for all of it now, and while the adapter is gone.
  bool send(const hal::CanFrame& frame) noexcept override;
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override;
  hal::CanBusState state() const noexcept override;
  hal::CanBusStats stats() const noexcept override;

  /// Opens an adapter that went away when it is time to try. Takes no longer than `at_most` by the clock and
  /// one try to open.
  void serve(Duration at_most) noexcept;

 private:
  bool open() noexcept;
  bool greet() noexcept;
  void close() noexcept;
  [[noreturn]] void explain(int error) const;

  bool fill() noexcept;
  bool send_rest() noexcept;
  std::size_t write(std::string_view text) noexcept;
  void note_refusal() noexcept;
  void lose() noexcept;
  bool refuse() noexcept;

  SlcanConfig config_;
  hal::Clock& clock_;
  BackOff retry_;

  // The descriptor is the bus loop's while this is set, and serve()'s while it is not.
  std::atomic<bool> is_open_ = false;
  int fd_ = -1;

  hal::CanBusStats stats_;
  SlcanReader reader_;
  std::array<char, 512> in_{};
  std::size_t in_next_ = 0, in_end_ = 0;  ///< what is read of it but not taken
  Time read_at_{};
  SlcanLine rest_of_;      ///< the line that the tty took a part of
  std::string_view rest_;  ///< what it did not take
  int refusals_ = 0;       ///< one after the other
};

}  // namespace headway::drivers
