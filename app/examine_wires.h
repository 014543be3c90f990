// The doctor's look at what is on the robot's wires: bus, head drives, control computer, cameras.
#pragma once

#include <functional>
#include <vector>

#include "app/camera_look.h"
#include "app/doctor.h"
#include "app/robot_file.h"
#include "drivers/device_calls.h"
#include "hal/can_bus.h"
#include "hal/clock.h"

namespace headway::app {

/// First listens for other_master(); where one is heard it says so and sends nothing. Else, for `time`, sets
/// the head's drives up, lets them hold where they are, and asks nothing of the control computer. Then it
/// leaves the head in order, as it does without a verdict when it is `asked` to end before. By a clock that
/// sleeps. `tells_state`: as CanTransport has it.
void examine_bus(
    const Robot& robot, hal::CanBus& bus, hal::Clock& clock, Duration time, Diagnosis& into,
    const std::function<bool()>& asked = [] { return false; }, bool tells_state = true);

/// How the cameras expose after a look through them.
void examine_exposures(const std::vector<EyeLook>& eyes, drivers::DeviceCalls& calls, Diagnosis& into);

/// What two cameras have shown, against what the robot file asks of them.
void examine_cameras(const CameraLook& look, const HardwareConfig& wanted, Diagnosis& into);

}  // namespace headway::app
