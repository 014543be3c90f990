#include "bench/runtime_cyclictest.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::bench {

namespace {

constexpr const char* kRemedy =
    "; scripts/setup installs rt-tests and stress-ng, and both need real-time rights";

std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  std::string text;
  std::array<char, 4096> some;
  while (pipe && std::fgets(some.data(), some.size(), pipe.get()) != nullptr) text += some.data();
  return text;
}

/// Microseconds -> how often; cyclictest's histogram has a line for each.
struct Delays {
  std::vector<std::uint64_t> counts;
  std::uint64_t beyond = 0;  ///< longer than the histogram reaches
  std::uint64_t largest = 0;
};

Delays read_histogram(const std::string& text) {
  Delays delays;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    unsigned long delay = 0, count = 0;
    if (std::sscanf(line.c_str(), "# Max Latencies: %lu", &delay) == 1) delays.largest = delay;
    if (std::sscanf(line.c_str(), "# Histogram Overflows: %lu", &count) == 1) delays.beyond = count;
    if (line.starts_with('#') || std::sscanf(line.c_str(), "%lu %lu", &delay, &count) != 2) continue;
    delays.counts.resize(std::max<std::size_t>(delays.counts.size(), delay + 1));
    delays.counts[delay] = count;
  }
  return delays;
}

}  // namespace

WakeUps cyclictest(Duration period, int priority, int processor, Duration length) {
  const auto us = [](std::uint64_t n) { return Duration(std::chrono::microseconds(n)); };
  const auto period_us = static_cast<std::size_t>(period / us(1));
  const std::size_t reach = 4 * period_us;
  const std::string text = output_of(fmt::format(
      "cyclictest --quiet --mlockall --default-system --threads=1 --priority={} --affinity={} --interval={} "
      "--loops={} --histogram={}",
      priority, processor, period_us, length / period, reach));
  const Delays delays = read_histogram(text);
  WakeUps result;
  for (std::size_t d = 0; d < delays.counts.size(); ++d) {
    result.count += delays.counts[d];
    if (d >= period_us) result.missed += delays.counts[d];
  }
  result.count += delays.beyond;
  result.missed += delays.beyond;
  if (result.count < static_cast<std::uint64_t>(length / period) / 2)
    throw Error(
        fmt::format("cyclictest woke up {} times, expected {}{}", result.count, length / period, kRemedy));
  const auto quantile = [&](double share) {
    std::uint64_t so_far = 0;
    for (std::size_t d = 0; d < delays.counts.size(); ++d)
      if (static_cast<double>(so_far += delays.counts[d]) >= share * static_cast<double>(result.count))
        return us(d);
    return us(delays.largest);
  };
  result.p50 = quantile(0.5);
  result.p99 = quantile(0.99);
  result.p999 = quantile(0.999);
  result.max = us(delays.largest);
  return result;
}

Load::Load(int processor) {
  const std::string where = std::to_string(processor);
  std::array<const char*, 8> arguments{"stress-ng", "--quiet",     "--cpu", "1",
                                       "--taskset", where.c_str(), nullptr};
  const int fault = ::posix_spawnp(&stress_, arguments[0], nullptr, nullptr,
                                   const_cast<char* const*>(arguments.data()), environ);
  if (fault != 0) throw Error(fmt::format("stress-ng: {}{}", std::strerror(fault), kRemedy));
}

Load::~Load() {
  ::kill(stress_, SIGTERM);
  int status = 0;
  ::waitpid(stress_, &status, 0);
}

}  // namespace headway::bench
