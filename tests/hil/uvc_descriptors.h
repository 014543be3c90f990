// What an emulated camera tells about itself: its descriptors, and the numbers that they share with its
// requests.
#pragma once

#include <array>
#include <cstdint>

#include "tests/hil/emulated_uvc.h"

namespace headway::hil::uvc {

constexpr std::uint8_t kControlInterface = 0, kStreamingInterface = 1;
constexpr std::uint8_t kCameraTerminal = 1, kProcessingUnit = 2, kOutputTerminal = 3;

/// Times between frames that the camera offers, in 100 ns; the first is where it starts.
constexpr std::array<std::uint32_t, 4> kIntervals{333'333, 666'666, 1'000'000, 2'000'000};
/// Bytes of one bulk transfer, header included: what the kernel asks for at a time.
constexpr std::uint32_t kPayloadSize = 16384;

UsbDescription describe(const EmulatedUvc::Config& config);

}  // namespace headway::hil::uvc
