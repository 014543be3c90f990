// Two processors for work that can be divided, without a word about threads.
#pragma once

namespace headway::hal {

/// A call of something that outlives the call.
class Task {
 public:
  template <class Work>
  explicit Task(const Work& work)
      : work_(&work), call_([](const void* of) { (*static_cast<const Work*>(of))(); }) {}
  void operator()() const { call_(work_); }

 private:
  const void* work_;
  void (*call_)(const void*);
};

/// Does two things at once, where there are two processors. Used by one thread; not from within its tasks.
class TwoProcessors {
 public:
  virtual ~TwoProcessors() = default;
  /// Both are done when it returns, and all that they wrote can be read. What one of them throws is thrown.
  template <class A, class B>
  void both(const A& a, const B& b) {
    run(Task(a), Task(b));
  }

 private:
  virtual void run(Task a, Task b) = 0;
};

/// The one processor that there always is: one thing after the other.
inline TwoProcessors& one_processor() {
  class One final : public TwoProcessors {
    void run(Task a, Task b) override {
      a();
      b();
    }
  };
  static One one;
  return one;
}

}  // namespace headway::hal
