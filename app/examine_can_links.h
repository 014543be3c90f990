// The doctor's look at the machine's CAN interfaces: which there are, and whether the robot's is set as it
// must be.
#pragma once

#include <string>
#include <vector>

#include "app/doctor.h"
#include "drivers/can_links.h"

namespace headway::app {

/// A line for each. `interface` is the robot's, as the kernel names it; empty where its bus is none of the
/// kernel's. `kernel_has_can`: whether it opens CAN sockets at all.
void examine_can_links(const std::vector<drivers::CanLink>& links, const std::string& interface,
                       Diagnosis& into, bool kernel_has_can = true);

}  // namespace headway::app
