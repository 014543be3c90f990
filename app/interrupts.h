// That the user or the service manager wants the program to end (SIGINT, SIGTERM), to be looked at between
// two pieces of work.
#pragma once

namespace headway::app {

/// From its making on the signals no longer end the program by themselves; a second one does.
class Interrupts {
 public:
  Interrupts();
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
  bool asked() const noexcept;
};

}  // namespace headway::app
