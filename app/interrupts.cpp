#include "app/interrupts.h"

#include <array>
#include <csignal>

#include <fcntl.h>
#include <unistd.h>

namespace headway::app {

namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t asked_to_end = 0, asked_to_read_again = 0;

void take(int) { asked_to_end = 1; }
void take_reload(int) { asked_to_read_again = 1; }

}  // namespace

HangUp hang_up_of_a_service() {
  const int terminal = ::open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC);
  if (terminal >= 0) ::close(terminal);
  return terminal >= 0 ? HangUp::kEnds : HangUp::kAsksToReload;
}

Interrupts::Interrupts(HangUp hang_up) {
  asked_to_end = 0;
  asked_to_read_again = 0;
  struct sigaction action {};
  action.sa_handler = take;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : kSignals) sigaction(signal, &action, nullptr);
  if (hang_up == HangUp::kAsksToReload) {
    action.sa_handler = take_reload;
    action.sa_flags = SA_RESTART;
    sigaction(SIGHUP, &action, nullptr);
  }
  std::signal(SIGPIPE, SIG_IGN);
}

Interrupts::~Interrupts() {
  for (const int signal : kSignals) std::signal(signal, SIG_DFL);
  std::signal(SIGPIPE, SIG_DFL);
}

bool Interrupts::asked() const noexcept { return asked_to_end != 0; }

bool Interrupts::asked_to_reload() noexcept {
  const bool asked = asked_to_read_again != 0;
  asked_to_read_again = 0;
  return asked;
}

}  // namespace headway::app
