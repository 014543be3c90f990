// That the user, the service manager or a terminal that closes wants the program to end (SIGINT, SIGTERM,
// SIGHUP), to be looked at between two pieces of work.
#pragma once

namespace headway::app {

/// While there is one, none of these signals ends the program by itself until the same has come before. Nor
/// does output that nobody reads any more (SIGPIPE).
class Interrupts {
 public:
  Interrupts();
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
  bool asked() const noexcept;
};

}  // namespace headway::app
