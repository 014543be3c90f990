// A second processor for the work between two frames.
#pragma once

#include <atomic>
#include <exception>
#include <semaphore>

#include "hal/two_processors.h"
#include "runtime/threads.h"

namespace headway::runtime {

/// The calling thread does the first of two tasks, a thread of its own the second.
class SecondProcessor final : public hal::TwoProcessors {
 public:
  SecondProcessor();
  ~SecondProcessor() override;

 private:
  void run(hal::Task here, hal::Task there) override;
  void work(const std::atomic<bool>& stop);

  const hal::Task* task_ = nullptr;  ///< given with `given_`, and back with `done_`
  std::exception_ptr fault_;         ///< likewise
  std::binary_semaphore given_{0}, done_{0};
  Thread thread_;
};

}  // namespace headway::runtime
