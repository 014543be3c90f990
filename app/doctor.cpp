#include "app/doctor.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "app/first_line.h"
#include "runtime/real_time.h"
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

void examine_rights(const MachineFacts& facts, Diagnosis& into) {
  const auto wanted = static_cast<std::uint64_t>(runtime::highest_priority());
  if (facts.root_user || facts.realtime_priority >= wanted)
    into.ok("real-time priority",
            facts.root_user ? "root may" : fmt::format("up to {}", facts.realtime_priority));
  else
    into.fail("real-time priority",
              fmt::format("up to {}, the bus loop wants {}", facts.realtime_priority, wanted),
              runtime::real_time_remedy());
  constexpr std::uint64_t kEnough = 512 * kMebibyte;
  if (facts.root_user || facts.locked_memory >= kEnough)
    into.ok("locked memory", facts.root_user || facts.locked_memory == kUnlimited
                                 ? "unlimited"
                                 : fmt::format("{} MiB", facts.locked_memory / kMebibyte));
  else
    into.warn("locked memory",
              fmt::format("{} MiB may be locked, expected {}", facts.locked_memory / kMebibyte,
                          kEnough / kMebibyte),
              runtime::real_time_remedy());
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
  struct statvfs disk {};
  if (statvfs(".", &disk) == 0) facts.disk_free = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
  return facts;
}

void examine_machine(const MachineFacts& facts, Diagnosis& into) {
  into.about("machine");
  into.ok("kernel", first_line(facts.root / "proc/sys/kernel/osrelease"));
  examine_rights(facts, into);
  examine_processors(facts, into);
  examine_disk(facts, into);
}

}  // namespace headway::app
