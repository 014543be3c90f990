// Two flows of control in one thread, one of which runs at a time: what is needed to step code from outside.
#pragma once

#include <array>
#include <functional>

#include <ucontext.h>

namespace headway {

/// Runs a body in pieces: resume() runs it until it calls pause(), or to its end. The body throws nothing.
class Fiber {
 public:
  Fiber();
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  /// Takes up another body, after the last one's end.
  void begin(std::function<void()> body);
  void resume();
  /// From within the body.
  void pause();
  bool ended() const { return ended_; }

 private:
  static void enter(unsigned high, unsigned low);
  void run();
  void leave(bool for_good);
  void arrive();

  std::function<void()> body_;
  bool ended_ = true;
  ucontext_t outside_{}, inside_{};
  std::array<char, 64 * 1024> stack_;
  // What the sanitizers must know of a switch:
  void* fake_outside_ = nullptr;
  void* fake_inside_ = nullptr;
  const void* outside_stack_ = nullptr;
  std::size_t outside_size_ = 0;
  void* tsan_outside_ = nullptr;
  void* tsan_inside_ = nullptr;
};

}  // namespace headway
