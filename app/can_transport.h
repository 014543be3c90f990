// A CAN bus by the name that people give it, on the command line and in a robot's file.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/can_bus.h"
#include "hal/clock.h"
#include "runtime/threads.h"

namespace headway::app {

struct CanTransport {
  std::unique_ptr<hal::CanBus> bus;
  /// What a thread that may wait must call over and over, saying how long it may take at most: it brings a
  /// lost adapter back. Empty where the bus needs none. Not to be called when the bus is no more.
  std::function<void(Duration)> serve;
  /// What the adapter says of itself, where the transport asks it; else empty.
  std::string adapter;
  /// Whether it tells what state the controller is in; where not, state() only knows whether it is gone.
  bool tells_state = true;
};

/// What open_can_transport() knows, for help texts.
std::string can_transports();

/// Whether a name is of this form.
bool is_can_transport(std::string_view name);

/// Opens `socketcan:INTERFACE`, `gs_usb:SERIAL` or `slcan:TTY`. Throws InputError where the name is neither,
/// and as the driver does where what it names cannot be opened. The clock must outlive the bus.
/// `listens_to` are the identifiers that the owner needs, empty: all. Where the kernel can, it hands over no
/// others.
CanTransport open_can_transport(const std::string& name, hal::Clock& clock,
                                const std::vector<std::uint32_t>& listens_to = {});

/// What the robot's loops listen to: all that others than the vision computer send (docs/bus.md).
std::vector<std::uint32_t> identifiers_of_the_loops();

/// A thread that does so, where the bus needs one; else null. The transport must outlive it. Throws as
/// runtime::Thread.
std::unique_ptr<runtime::Thread> serve(const CanTransport& transport,
                                       const runtime::RealTime& real_time = {});

}  // namespace headway::app
