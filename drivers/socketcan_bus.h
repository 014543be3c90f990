// A CAN bus on an interface of the Linux kernel (SocketCAN: Documentation/networking/can.rst). It comes back
// by itself when the interface does.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/back_off.h"
#include "drivers/can_socket_calls.h"
#include "hal/can_bus.h"
#include "hal/clock.h"

namespace headway::drivers {

struct SocketCanConfig {
  std::string interface = "can0";                   ///< as `ip link` names it; it must be up
  std::vector<std::uint32_t> identifiers{};         ///< the 11-bit identifiers to receive; empty: all frames
  Duration stall = std::chrono::milliseconds(100);  ///< without room to send for so long, the bus is at fault
  BackOffConfig retry{};                            ///< of opening an interface that went away

  /// Throws InputError.
  void validate() const;
};

/// For one thread. Real-time safe but for the moment in which receive() opens an interface anew: that waits
/// for others who are just changing the kernel's list of interfaces, and happens only while the bus is gone.
///
/// state() is what the controller reports in its error frames, or kGone while there is no interface or it is
/// down; and kBusOff as long as an interface that is opened is up and does not run, which the kernel tells up
/// to a second late, and not of each driver. It is kBusOff as well while frames wait and none has left for
/// config.stall: `bus_off` counts both. Stamps are the kernel's: when its driver took the frame from the
/// controller.
class SocketCanBus final : public hal::CanBus {
 public:
  /// Opens the interface. Throws InputError where the configuration or the interface is wrong, Error where
  /// the kernel is. Clock and calls must outlive the bus.
  SocketCanBus(const SocketCanConfig& config, const hal::Clock& clock,
               CanSocketCalls& calls = kernel_can_socket_calls());
  ~SocketCanBus() override;
  SocketCanBus(const SocketCanBus&) = delete;
  SocketCanBus& operator=(const SocketCanBus&) = delete;

  /// False when the kernel has no room, and while the bus is off or gone: nothing is kept to be sent later.
  bool send(const hal::CanFrame& frame) noexcept override;
  /// Also hears the controller's error frames, and tries to open an interface that went away.
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override;
  hal::CanBusState state() const noexcept override;
  hal::CanBusStats stats() const noexcept override;

 private:
  /// What opening could not do, and errno.
  enum class Step : std::uint8_t { kSocket, kFind, kUp, kOptions, kBind };
  struct Fault {
    Step step;
    int error;
  };

  std::optional<Fault> open() noexcept;
  std::optional<Fault> set_up(int fd) noexcept;
  bool set_options(int fd) noexcept;
  void look_whether_it_runs() noexcept;
  [[noreturn]] void explain(const Fault& fault) const;
  bool reopen() noexcept;
  void leave() noexcept;

  int read(std::size_t most) noexcept;
  bool take(std::size_t slot, Time now, Duration wall_now, hal::CanFrame& into) noexcept;
  void hear_error(const can_frame& frame) noexcept;
  void note_full() noexcept;
  bool refuse() noexcept;

  static constexpr std::size_t kBatch = 32;         ///< frames read in one call
  static constexpr std::size_t kControlSize = 128;  ///< bytes for a frame's stamp and the count of lost ones

  SocketCanConfig config_;
  const hal::Clock& clock_;
  CanSocketCalls& calls_;
  std::vector<can_filter> filters_;
  BackOff retry_;
  int fd_ = -1;

  hal::CanBusState controller_ = hal::CanBusState::kErrorActive;
  bool seems_off_ = false;  ///< by the interface's flags, for want of an error frame
  hal::CanBusStats stats_;
  std::uint32_t overflowed_ = 0;    ///< frames this socket has lost, as last told
  Time emptied_{};                  ///< when nothing was left to be read
  std::optional<Time> full_since_;  ///< since then there was no room to send
  bool stalled_ = false;

  std::array<mmsghdr, kBatch> headers_{};
  std::array<iovec, kBatch> vectors_{};
  std::array<can_frame, kBatch> frames_{};
  struct alignas(cmsghdr) Control {
    std::array<std::byte, kControlSize> bytes;
  };
  std::array<Control, kBatch> controls_{};
};

}  // namespace headway::drivers
