// That the user, the service manager or a terminal that closes wants the program to end (SIGINT, SIGTERM,
// SIGHUP), to be looked at between two pieces of work.
//
// SIGHUP to a service, which has no terminal, asks to read its files again, by custom; that is for the
// service to answer.
#pragma once

#include <cstdint>

namespace headway::app {

enum class HangUp : std::uint8_t {
  kEnds,          ///< SIGHUP wants the program to end, as the others do
  kAsksToReload,  ///< SIGHUP is no more than asked_to_reload()
};

/// Of a program that may run as a service: by whether it runs in a terminal, which may close.
HangUp hang_up_of_a_service();

/// While there is one, none of these signals ends the program by itself until the same has come before. Nor
/// does output that nobody reads any more (SIGPIPE).
class Interrupts {
 public:
  explicit Interrupts(HangUp hang_up = HangUp::kEnds);
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
  bool asked() const noexcept;
  /// True once for each time that it was asked to read its files again.
  bool asked_to_reload() noexcept;
};

}  // namespace headway::app
