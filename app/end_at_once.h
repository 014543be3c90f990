// How the program ends when one of its threads hangs: at once, with nothing taken away that the thread may
// still use. Open devices are closed by the kernel.
#pragma once

#include <string>

namespace headway::app {

/// Says the error in one line, and ends with the exit code of a fault of the program or the machine.
[[noreturn]] void end_at_once(const std::string& error);

}  // namespace headway::app
