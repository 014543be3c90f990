// What the programs that run an emulated device share: they plug it in, answer the kernel and obey their pipe
// until they are ended.
#pragma once

#include <functional>
#include <optional>

#include "tests/hil/command_pipe.h"
#include "tests/hil/usbip_port.h"

namespace headway::hil {

/// Told how long to wait for the kernel or a command in milliseconds, -1 for ever. Called before each wait.
using NextWait = std::function<int()>;
/// What a device does by a command of its own; false where it knows none such.
using Obey = std::function<bool(const Command&)>;

/// Runs until SIGTERM or SIGINT. Understands `plug`, `unplug` and `stall ENDPOINT` (0 is the next control
/// request, 0x81 the endpoint to the host), and hands on all else. An unknown command is told on the error
/// output.
void run_usb_program(UsbipPort& port, CommandPipe& commands, const Obey& obey, const NextWait& next_wait);

/// The end of such a program: what `run` returns, or 2 where it throws an Error, told under the program's
/// name on the error output.
int run_reporting(const char* program, int (*run)(int, char**), int argc, char** argv);

}  // namespace headway::hil
