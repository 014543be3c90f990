#include "app/interrupts.h"

#include <array>
#include <csignal>

namespace headway::app {

namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t asked_to_end = 0;

void take(int) { asked_to_end = 1; }

}  // namespace

Interrupts::Interrupts() {
  asked_to_end = 0;
  struct sigaction action {};
  action.sa_handler = take;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int signal : kSignals) sigaction(signal, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

Interrupts::~Interrupts() {
  for (const int signal : kSignals) std::signal(signal, SIG_DFL);
  std::signal(SIGPIPE, SIG_DFL);
}

bool Interrupts::asked() const noexcept { return asked_to_end != 0; }

}  // namespace headway::app
