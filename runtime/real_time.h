// What the program asks of the kernel so that its urgent threads run on time: priority, a processor, memory
// that stays; and what it says when that is refused.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace headway::runtime {

/// The system calls, as a table: the kernel's, or a script's in tests. Each returns 0 or errno. The first two
/// are about the calling thread.
class RealTimeCalls {
 public:
  virtual ~RealTimeCalls() = default;
  /// Under SCHED_FIFO, at `priority` (sched(7)).
  virtual int be_urgent(int priority) noexcept = 0;
  /// On no other processor than this (sched_setaffinity(2)).
  virtual int stay_on(int processor) noexcept = 0;
  /// All memory, present and future (mlockall(2)).
  virtual int lock_memory() noexcept = 0;
  /// Whether as much may be locked as there is; where not, memory that is asked for later would be refused.
  virtual bool may_lock_all() noexcept = 0;
};
RealTimeCalls& kernel_real_time() noexcept;

struct RealTime {
  enum class Want : std::uint8_t {
    kOff,      ///< nothing is asked for
    kTry,      ///< what is refused is told, and done without
    kEnforce,  ///< what is refused ends the program before anything moves
  };
  Want want = Want::kTry;
  std::optional<int> bus_processor;  ///< the bus loop's; none: any
  RealTimeCalls* calls = &kernel_real_time();
};

/// Which lines give a user, or a unit of systemd, all rights that are asked for.
std::string real_time_remedy();

/// For the calling thread: as urgent as that, on that processor if any, its stack at hand. `thread` names it.
/// What was refused, and the remedy; empty when all was granted, or nothing asked for. Priority 0: an
/// ordinary thread, for which no urgency is asked. Throws nothing, whatever is wanted.
std::string make_urgent(const std::string& thread, int priority, std::optional<int> processor,
                        const RealTime& real_time);

/// Keeps all memory, present and future, from being paged out. What was refused, and the remedy; else empty.
/// Throws InputError instead with kEnforce.
std::string lock_memory(const RealTime& real_time);

}  // namespace headway::runtime
