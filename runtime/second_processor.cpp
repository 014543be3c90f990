#include "runtime/second_processor.h"

#include <utility>

namespace headway::runtime {

SecondProcessor::SecondProcessor()
    : thread_(ThreadId::kSecond, [this](const std::atomic<bool>& stop) { work(stop); }) {}

SecondProcessor::~SecondProcessor() {
  thread_.ask_to_stop();
  given_.release();
  thread_.stop();
}

void SecondProcessor::run(hal::Task here, hal::Task there) {
  task_ = &there;
  given_.release();
  std::exception_ptr fault;
  try {
    here();
  } catch (...) {
    fault = std::current_exception();
  }
  done_.acquire();  // in any case: the other task uses what the caller owns
  if (!fault) fault = fault_;
  fault_ = nullptr;
  if (fault) std::rethrow_exception(fault);
}

void SecondProcessor::work(const std::atomic<bool>& stop) {
  for (given_.acquire(); !stop; given_.acquire()) {
    try {
      (*task_)();
    } catch (...) {
      fault_ = std::current_exception();
    }
    done_.release();
  }
}

}  // namespace headway::runtime
