#include "tests/hil/usb_program.h"

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>

#include "hal/error.h"

namespace headway::hil {
namespace {

volatile std::sig_atomic_t ended = 0;

void end_on_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { ended = 1; };
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGINT, &action, nullptr);
}

bool obey_port(UsbipPort& port, const Command& command) {
  if (command == Command{"plug"}) {
    port.plug();
  } else if (command == Command{"unplug"}) {
    port.unplug();
  } else if (command.size() == 2 && command[0] == "stall") {
    port.stall(static_cast<std::uint8_t>(std::strtoul(command[1].c_str(), nullptr, 0)));
  } else {
    return false;
  }
  return true;
}

}  // namespace

void run_usb_program(UsbipPort& port, CommandPipe& commands, const Obey& obey, const NextWait& next_wait) {
  end_on_signals();
  port.plug();
  while (ended == 0) {
    std::array<pollfd, 2> files{{{.fd = port.descriptor(), .events = POLLIN, .revents = 0},
                                 {.fd = commands.descriptor(), .events = POLLIN, .revents = 0}}};
    ::poll(files.data(), files.size(), next_wait());
    if ((files[0].revents & (POLLIN | POLLHUP | POLLERR)) != 0) port.answer_message();
    while (const auto command = commands.next()) {
      const bool known = obey_port(port, *command) || obey(*command);
      fmt::print(stderr, "{}: {}\n", known ? "done" : "unknown command", fmt::join(*command, " "));
    }
    port.send_waiting();
  }
}

int run_reporting(const char* program, int (*run)(int, char**), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    fmt::print(stderr, "{}: {}\n", program, error.what());
    return 2;
  }
}

}  // namespace headway::hil
