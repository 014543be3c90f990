// A bell between threads that can be waited for together with file descriptors (an eventfd).
#pragma once

namespace headway::drivers {

class WakeUp {
 public:
  /// Throws Error when the machine has no descriptors left.
  WakeUp();
  ~WakeUp();
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;

  /// From any thread; neither blocks nor allocates. Rung twice before anybody heard is rung once.
  void ring() noexcept;
  /// The listener: silences the bell.
  void hear() noexcept;
  /// Readable while the bell rings.
  int descriptor() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace headway::drivers
