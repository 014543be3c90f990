// That the user, the service manager or a terminal that closes wants the program to end (SIGINT, SIGTERM,
// SIGHUP), to be looked at between two pieces of work.
//
// SIGHUP to a program without a terminal asks to read its files again, by custom; that is for the caller to
// answer.
#pragma once

namespace headway::app {

/// Whether the program runs in a terminal, which may close.
bool has_terminal();

/// While there is one, none of these signals ends the program by itself until the same has come before. Nor
/// does output that nobody reads any more (SIGPIPE).
class Interrupts {
 public:
  explicit Interrupts(bool terminal = has_terminal());
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
  bool asked() const noexcept;
  /// True once for each time that it was asked to read its files again.
  bool asked_to_reload() noexcept;
};

}  // namespace headway::app
