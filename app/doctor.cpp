#include "app/doctor.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "app/first_line.h"
#include "hal/angle.h"
#include "runtime/threads.h"

namespace headway::app {

namespace {

constexpr std::uint64_t kUnlimited = RLIM_INFINITY;
constexpr std::uint64_t kMebibyte = 1 << 20;

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kWarn:
      return "warn";
    case Verdict::kFail:
      return "fail";
  }
  return "?";
}

using Want = runtime::RealTime::Want;

void examine_priority(const MachineFacts& facts, Want want, Diagnosis& into) {
  const auto wanted = static_cast<std::uint64_t>(runtime::highest_priority());
  if (facts.root_user || facts.realtime_priority >= wanted)
    into.ok("real-time priority",
            facts.root_user ? "root may" : fmt::format("up to {}", facts.realtime_priority));
  else if (want == Want::kEnforce)
    into.fail("real-time priority",
              fmt::format("up to {}, and 'run' does not start with less than {} (real_time: enforce)",
                          facts.realtime_priority, wanted),
              runtime::real_time_remedy());
  else
    into.warn("real-time priority",
              fmt::format("up to {}, the bus loop wants {}", facts.realtime_priority, wanted),
              runtime::real_time_remedy());
}

void examine_memory_lock(const MachineFacts& facts, Want want, Diagnosis& into) {
  constexpr std::uint64_t kEnough = 512 * kMebibyte;
  const bool all = facts.root_user || facts.locked_memory == kUnlimited;
  const std::string limit = fmt::format("{} MiB", facts.locked_memory / kMebibyte);
  if (all)
    into.ok("locked memory", "unlimited");
  else if (want == Want::kEnforce)
    into.fail("locked memory",
              limit + " may be locked, and 'run' does not start with less than all (real_time: enforce)",
              runtime::real_time_remedy());
  else if (facts.locked_memory >= kEnough)
    into.ok("locked memory", limit);
  else
    into.warn("locked memory", fmt::format("{} may be locked, expected {}", limit, kEnough / kMebibyte),
              runtime::real_time_remedy());
}

void examine_bus_processor(const MachineFacts& facts, int processor, Want want, Diagnosis& into) {
  const std::string what = "bus processor", found = fmt::format("{}", processor),
                    remedy =
                        "runtime: bus_processor in the robot file: expected one of those that 'nproc' "
                        "counts, from 0 on";
  if (facts.may_run_on(processor))
    into.ok(what, found);
  else if (want == Want::kEnforce)
    into.fail(what, found + " is refused, and 'run' does not start without (real_time: enforce)", remedy);
  else
    into.warn(what, found + " is refused: the bus loop runs on any", remedy);
}

void examine_rights(const MachineFacts& facts, const runtime::RealTime& wanted, Diagnosis& into) {
  if (wanted.want == Want::kOff) {
    into.ok("real-time rights", "not asked for (runtime: real_time: off)");
    return;
  }
  examine_priority(facts, wanted.want, into);
  examine_memory_lock(facts, wanted.want, into);
  if (wanted.bus_processor) examine_bus_processor(facts, *wanted.bus_processor, wanted.want, into);
}

/// Tried out, for it may be one that is kept free of others.
bool kernel_lets_run_on(int processor) {
  cpu_set_t before;
  if (sched_getaffinity(0, sizeof before, &before) != 0) return false;
  const bool may = runtime::kernel_real_time().stay_on(processor) == 0;
  sched_setaffinity(0, sizeof before, &before);
  return may;
}

void examine_processors(const MachineFacts& facts, Diagnosis& into) {
  namespace fs = std::filesystem;
  std::set<std::string> governors;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(facts.root / "sys/devices/system/cpu", none)) {
    const std::string governor = first_line(entry.path() / "cpufreq/scaling_governor");
    if (!governor.empty()) governors.insert(governor);
  }
  if (governors.empty())
    into.ok("CPU governor", "none: the clock does not change");
  else if (governors == std::set<std::string>{"performance"})
    into.ok("CPU governor", "performance");
  else
    into.warn("CPU governor", fmt::format("{}", fmt::join(governors, ", ")),
              "'cpupower frequency-set -g performance' (package linux-cpupower); else the first frames after "
              "a rest "
              "are late");
  const std::string source =
      first_line(facts.root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  const bool fast = source == "tsc" || source == "arch_sys_counter" || source == "kvm-clock";
  if (fast)
    into.ok("clock source", source);
  else
    into.warn(
        "clock source", source.empty() ? "unknown" : source,
        "look at 'dmesg | grep -i tsc' for why the fast clock is not used; with others each look at the time "
        "costs a microsecond and more");
}

void examine_disk(const MachineFacts& facts, Diagnosis& into) {
  const std::string found = fmt::format("{} MiB free", facts.disk_free / kMebibyte);
  if (facts.disk_free < 100 * kMebibyte)
    into.fail("disk", found, "make room: maps and recordings cannot be written");
  else if (facts.disk_free < 2048 * kMebibyte)
    into.warn("disk", found, "make room: a recording takes 1 GiB and more");
  else
    into.ok("disk", found);
}

}  // namespace

void Diagnosis::ok(std::string what, std::string found) {
  findings_.push_back({Verdict::kOk, part_, std::move(what), std::move(found), {}});
}

void Diagnosis::warn(std::string what, std::string found, std::string remedy) {
  findings_.push_back({Verdict::kWarn, part_, std::move(what), std::move(found), std::move(remedy)});
}

void Diagnosis::fail(std::string what, std::string found, std::string remedy) {
  findings_.push_back({Verdict::kFail, part_, std::move(what), std::move(found), std::move(remedy)});
}

Verdict Diagnosis::worst() const {
  Verdict worst = Verdict::kOk;
  for (const Finding& finding : findings_) worst = std::max(worst, finding.verdict);
  return worst;
}

std::string Diagnosis::text(std::size_t first) const {
  std::string lines;
  for (const Finding& f : std::span(findings_).subspan(first)) {
    lines += fmt::format("{:4}  {:8} {}: {}\n", word(f.verdict), f.part, f.what, f.found);
    if (!f.remedy.empty()) lines += fmt::format("                 {}\n", f.remedy);
  }
  return lines;
}

Json Diagnosis::json() const {
  Json all = Json::array();
  for (const Finding& f : findings_)
    all.push_back({{"verdict", word(f.verdict)},
                   {"part", f.part},
                   {"what", f.what},
                   {"found", f.found},
                   {"remedy", f.remedy}});
  return {{"verdict", word(worst())}, {"findings", std::move(all)}};
}

MachineFacts MachineFacts::of_this_machine() {
  MachineFacts facts;
  rlimit limit{};
  if (getrlimit(RLIMIT_RTPRIO, &limit) == 0) facts.realtime_priority = limit.rlim_cur;
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0) facts.locked_memory = limit.rlim_cur;
  facts.root_user = geteuid() == 0;
  facts.may_run_on = kernel_lets_run_on;
  struct statvfs disk {};
  if (statvfs(".", &disk) == 0) facts.disk_free = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
  return facts;
}

void examine_machine(const MachineFacts& facts, const runtime::RealTime& wanted, Diagnosis& into) {
  into.about("machine");
  into.ok("kernel", first_line(facts.root / "proc/sys/kernel/osrelease"));
  examine_rights(facts, wanted, into);
  examine_processors(facts, into);
  examine_disk(facts, into);
}

void examine_head_limits(const hal::HeadLimits& limits, Diagnosis& into) {
  constexpr double kLeast = 5 * kDegree;
  into.about("head");
  const auto& [lower, upper] = std::tie(limits.lower, limits.upper);
  const std::string found =
      fmt::format("pan {:.1f} to {:.1f} deg, tilt {:.1f} to {:.1f} deg", lower.pan / kDegree,
                  upper.pan / kDegree, lower.tilt / kDegree, upper.tilt / kDegree);
  if (upper.pan - lower.pan < kLeast || upper.tilt - lower.tilt < kLeast)
    into.warn("limits", found,
              "a head that can hardly move sees little: neck: pan_deg and tilt_deg in the robot file are "
              "degrees, not radians");
  else
    into.ok("limits", found);
}

}  // namespace headway::app
