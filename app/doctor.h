// Findings about a machine and the robot on its wires, for a person who brings the hardware up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/report.h"
#include "hal/head.h"
#include "runtime/real_time.h"

namespace headway::app {

enum class Verdict : std::uint8_t { kOk, kWarn, kFail };

struct Finding {
  Verdict verdict = Verdict::kOk;
  std::string part;    ///< "machine", "bus", "head", ...
  std::string what;    ///< what was looked at
  std::string found;   ///< what was seen
  std::string remedy;  ///< what to do about it; empty when nothing needs doing
};

/// The findings so far; as lines for a person, or as JSON.
class Diagnosis {
 public:
  explicit Diagnosis(std::string part = {}) : part_(std::move(part)) {}

  /// Findings from now on are about this part.
  void about(std::string part) { part_ = std::move(part); }
  void ok(std::string what, std::string found);
  void warn(std::string what, std::string found, std::string remedy);
  void fail(std::string what, std::string found, std::string remedy);

  const std::vector<Finding>& findings() const { return findings_; }
  Verdict worst() const;
  /// Of all, or of those from the `first` on.
  std::string text(std::size_t first = 0) const;
  Json json() const;

 private:
  std::string part_;
  std::vector<Finding> findings_;
};

/// What the machine's own rights and settings are; a test may put other files and limits in their place.
struct MachineFacts {
  std::filesystem::path root = "/";
  std::uint64_t realtime_priority = 0;  ///< RLIMIT_RTPRIO
  std::uint64_t locked_memory = 0;      ///< RLIMIT_MEMLOCK [bytes]
  bool root_user = false;
  std::uint64_t disk_free = 0;  ///< where the program stands [bytes]
  bool (*may_run_on)(int processor) = [](int) { return true; };
  static MachineFacts of_this_machine();
};

/// Real-time rights, memory lock and processor, as they are `wanted`; CPU governor, clock source, kernel,
/// disk.
void examine_machine(const MachineFacts& facts, const runtime::RealTime& wanted, Diagnosis& into);

/// Whether the head can look around.
void examine_head_limits(const hal::HeadLimits& limits, Diagnosis& into);

}  // namespace headway::app
