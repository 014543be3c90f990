// Code that shares memory between two threads, run through every interleaving of its atomic operations and
// every value that C++'s memory orders let a load see (in the model of release and acquire without load
// buffering, RC11: Lahav et al., "Repairing sequential consistency in C/C++11", PLDI 2017; operational, by
// views, as in Kang et al., "A promising semantics for relaxed-memory concurrency", POPL 2017).
//
// A store is appended to its variable's history; a load may see any store that its thread is not yet known to
// have gone past. What a releasing store's thread knew goes over to the thread whose acquiring load sees it;
// so do clocks, by which two accesses to plain data are ordered or a race.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace headway::interleavings {

inline constexpr std::size_t kThreads = 3;  // two, and the one that begins and ends
inline constexpr std::size_t kMostVariables = 8;

/// What a thread knows: how far it has gone in each variable's history, and what has happened before.
struct View {
  std::array<std::uint32_t, kMostVariables> seen{};
  std::array<std::uint32_t, kThreads> clock{};
  void join(const View& other);
};

/// An order that is weaker than what the code says, or an exchange that is no exchange: a fault planted to
/// prove that it would be found.
enum class Fault : std::uint8_t {
  kNone,
  kLoadRelaxed,
  kStoreRelaxed,
  kExchangeNoAcquire,
  kExchangeNoRelease,
  kExchangeInTwo
};

struct Planted {
  Fault fault = Fault::kNone;
  std::size_t variable = 0;                ///< in the order in which they are constructed
  std::optional<std::size_t> thread = {};  ///< only where this one does it; none: anywhere
};

/// The memory of one run, and who runs.
class Memory {
 public:
  std::size_t new_variable(std::uint64_t value);
  std::uint64_t load(std::size_t variable, std::memory_order order);
  void store(std::size_t variable, std::uint64_t value, std::memory_order order);
  std::uint64_t exchange(std::size_t variable, std::uint64_t value, std::memory_order order);
  std::uint64_t fetch_add(std::size_t variable, std::uint64_t value, std::memory_order order);

  /// Of plain data: when each thread touched it last.
  struct Touched {
    std::array<std::uint32_t, kThreads> reads{}, writes{};
  };
  void read(Touched& data);
  void write(Touched& data);

  /// What was not as it should be, first of all in this run.
  void fail(const std::string& what);

 private:
  friend class Explorer;
  struct Store {
    std::uint64_t value = 0;
    View released;  ///< what a thread that acquires it learns
  };
  void step();
  bool planted(std::size_t variable, Fault fault) const;
  std::uint64_t modify(std::size_t variable, std::memory_order order,
                       const std::function<std::uint64_t(std::uint64_t)>& change);
  void append(std::size_t variable, std::uint64_t value, bool releases, const View& carried);
  void race_unless_before(const std::array<std::uint32_t, kThreads>& touched, const char* what);

  std::vector<std::vector<Store>> histories_;
  std::array<View, kThreads> views_{};
  std::size_t running_ = kThreads - 1;
  Planted planted_;
  std::string failure_;
};

/// The memory of the run under way.
Memory& memory();

/// In place of std::atomic.
template <class T>
class Atomic {
 public:
  explicit Atomic(T value) : variable_(memory().new_variable(static_cast<std::uint64_t>(value))) {}
  T load(std::memory_order order) const { return static_cast<T>(memory().load(variable_, order)); }
  void store(T value, std::memory_order order) {
    memory().store(variable_, static_cast<std::uint64_t>(value), order);
  }
  T exchange(T value, std::memory_order order) {
    return static_cast<T>(memory().exchange(variable_, static_cast<std::uint64_t>(value), order));
  }
  T fetch_add(T value, std::memory_order order) {
    return static_cast<T>(memory().fetch_add(variable_, static_cast<std::uint64_t>(value), order));
  }

 private:
  std::size_t variable_;
};

/// Plain data that knows who touches it.
class Plain {
 public:
  Plain() : Plain(0) {}
  explicit Plain(int value) : value_(value) { memory().write(touched_); }
  Plain(const Plain& other) : Plain(other.value()) {}
  Plain& operator=(const Plain& other) noexcept {
    const int value = other.value();
    memory().write(touched_);
    value_ = value;
    return *this;
  }
  int value() const {
    memory().read(touched_);
    return value_;
  }

 private:
  mutable Memory::Touched touched_;
  int value_;
};

/// Made anew for each run: what the two threads do, and what is looked at when both have ended. It owns what
/// they share.
struct Program {
  std::array<std::function<void()>, 2> threads;
  std::function<void()> after;
};

struct Result {
  std::uint64_t runs = 0;
  std::uint64_t failed = 0;
  std::string failure;  ///< of the first that failed
};

/// All runs there are.
Result explore(const std::function<Program()>& make, const Planted& planted = {});

}  // namespace headway::interleavings
