#include "tests/hal/interleavings.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "tests/hal/fiber.h"

namespace headway::interleavings {

namespace {

bool acquires(std::memory_order order) {
  return order == std::memory_order_acquire || order == std::memory_order_acq_rel;
}
bool releases(std::memory_order order) {
  return order == std::memory_order_release || order == std::memory_order_acq_rel;
}

/// Depth first through all choices of a run: run after run, the last one that has another way takes it.
class Choices {
 public:
  std::size_t choose(std::size_t count) {
    if (count < 2) return 0;
    if (at_ == made_.size()) made_.push_back({0, count});
    return made_[at_++].chosen;
  }
  /// Whether there is another run.
  bool next() {
    at_ = 0;
    while (!made_.empty() && made_.back().chosen + 1 == made_.back().count) made_.pop_back();
    if (made_.empty()) return false;
    ++made_.back().chosen;
    return true;
  }

 private:
  struct Choice {
    std::size_t chosen, count;
  };
  std::vector<Choice> made_;
  std::size_t at_ = 0;
};

constexpr std::size_t kOutside = kThreads - 1;

}  // namespace

void View::join(const View& other) {
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = std::max(seen[i], other.seen[i]);
  for (std::size_t i = 0; i < clock.size(); ++i) clock[i] = std::max(clock[i], other.clock[i]);
}

/// Runs the threads, and makes the choices.
class Explorer {
 public:
  Result explore(const std::function<Program()>& make, const Planted& planted) {
    Result result;
    do {
      memory_ = Memory();
      memory_.planted_ = planted;
      memory_.views_[kOutside].clock[kOutside] = 1;
      run(make());
      ++result.runs;
      if (memory_.failure_.empty()) continue;
      if (result.failed++ == 0) result.failure = memory_.failure_;
    } while (choices_.next());
    return result;
  }

  /// Of the thread that runs: others may go first.
  void step() {
    if (memory_.running_ != kOutside) fibers_[memory_.running_].pause();
  }
  std::size_t choose(std::size_t count) { return choices_.choose(count); }
  Memory& memory() { return memory_; }

 private:
  void run(const Program& program) {
    for (std::size_t i = 0; i < fibers_.size(); ++i) {
      memory_.views_[i].join(memory_.views_[kOutside]);
      memory_.views_[i].clock[i] = 1;
      fibers_[i].begin(program.threads[i]);
      go_on(i);  // up to its first atomic operation: nobody sees when that was
    }
    std::vector<std::size_t> going;
    for (std::size_t i = 0; i < fibers_.size(); ++i)
      if (!fibers_[i].ended()) going.push_back(i);
    while (!going.empty()) {
      const std::size_t chosen = choose(going.size());
      go_on(going[chosen]);
      if (fibers_[going[chosen]].ended()) going.erase(going.begin() + static_cast<std::ptrdiff_t>(chosen));
    }
    memory_.running_ = kOutside;
    for (std::size_t i = 0; i < fibers_.size(); ++i) memory_.views_[kOutside].join(memory_.views_[i]);
    program.after();
  }

  void go_on(std::size_t thread) {
    memory_.running_ = thread;
    fibers_[thread].resume();
  }

  Memory memory_;
  Choices choices_;
  std::array<Fiber, kThreads - 1> fibers_;
};

namespace {
std::unique_ptr<Explorer> explorer;
}

Memory& memory() {
  if (!explorer) throw std::logic_error("only within explore()");
  return explorer->memory();
}

Result explore(const std::function<Program()>& make, const Planted& planted) {
  explorer = std::make_unique<Explorer>();
  const Result result = explorer->explore(make, planted);
  explorer.reset();
  return result;
}

void Memory::step() { explorer->step(); }

bool Memory::planted(std::size_t variable, Fault fault) const {
  return planted_.fault == fault && planted_.variable == variable &&
         planted_.thread.value_or(running_) == running_;
}

void Memory::append(std::size_t variable, std::uint64_t value, bool is_released, const View& carried) {
  View& view = views_[running_];
  view.seen[variable] = static_cast<std::uint32_t>(histories_[variable].size());
  Store store{value, carried};
  if (is_released) store.released.join(view);
  histories_[variable].push_back(store);
  ++view.clock[running_];  // what comes now was not released with this
}

std::size_t Memory::new_variable(std::uint64_t value) {
  const std::size_t variable = histories_.size();
  if (variable == kMostVariables) throw std::logic_error("more variables than kMostVariables");
  histories_.emplace_back();
  append(variable, value, false, {});
  return variable;
}

std::uint64_t Memory::load(std::size_t variable, std::memory_order order) {
  step();
  View& view = views_[running_];
  const std::uint32_t oldest = view.seen[variable];
  const std::size_t back = explorer->choose(histories_[variable].size() - oldest);
  const std::size_t seen = histories_[variable].size() - 1 - back;
  const Store& store = histories_[variable][seen];
  view.seen[variable] = static_cast<std::uint32_t>(seen);
  if (acquires(order) && !planted(variable, Fault::kLoadRelaxed)) view.join(store.released);
  return store.value;
}

void Memory::store(std::size_t variable, std::uint64_t value, std::memory_order order) {
  step();
  append(variable, value, releases(order) && !planted(variable, Fault::kStoreRelaxed), {});
}

/// Sees the newest store, and carries on what that released.
std::uint64_t Memory::modify(std::size_t variable, std::memory_order order,
                             const std::function<std::uint64_t(std::uint64_t)>& change) {
  step();
  const Store last = histories_[variable].back();
  if (acquires(order) && !planted(variable, Fault::kExchangeNoAcquire)) views_[running_].join(last.released);
  append(variable, change(last.value), releases(order) && !planted(variable, Fault::kExchangeNoRelease),
         last.released);
  return last.value;
}

std::uint64_t Memory::exchange(std::size_t variable, std::uint64_t value, std::memory_order order) {
  if (!planted(variable, Fault::kExchangeInTwo))
    return modify(variable, order, [&](std::uint64_t) { return value; });
  const std::uint64_t old = load(variable, std::memory_order_acquire);
  store(variable, value, std::memory_order_release);
  return old;
}

std::uint64_t Memory::fetch_add(std::size_t variable, std::uint64_t value, std::memory_order order) {
  return modify(variable, order, [&](std::uint64_t old) { return old + value; });
}

void Memory::race_unless_before(const std::array<std::uint32_t, kThreads>& touched, const char* what) {
  for (std::size_t i = 0; i < kThreads; ++i)
    if (i != running_ && touched[i] > views_[running_].clock[i]) fail(what);
}

void Memory::read(Touched& data) {
  race_unless_before(data.writes, "race: read while it is written");
  data.reads[running_] = views_[running_].clock[running_];
}

void Memory::write(Touched& data) {
  race_unless_before(data.writes, "race: written by both");
  race_unless_before(data.reads, "race: written while it is read");
  data.writes[running_] = views_[running_].clock[running_];
}

void Memory::fail(const std::string& what) {
  if (failure_.empty()) failure_ = what;
}

}  // namespace headway::interleavings
