// How punctual the bus loop is, and how long the whole work on a frame takes beside it.
//
// bus_cycle: the loop as the program runs it (200 Hz, SCHED_FIFO, memory locked) with its masters and a
// simulated robot, and cyclictest at the same period and priority, in turns, on the processor that stress-ng
// keeps busy. The medians of the runs' p99.9 wake-up delays are compared. A cycle of ours is later than one
// period when one was missed; of cyclictest's, when its delay was longer. Both have no power management but
// the machine's. frame: a recorded walk through explored space (runtime_walk.h) at the cameras' own 15 Hz,
// beside the same bus loop.
//
// `--seconds N` is the length of a run (120), `--runs N` how many there are of each (5).
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <opencv2/core/utility.hpp>
#include <unistd.h>

#include "bench/arguments.h"
#include "bench/figures.h"
#include "bench/runtime_cyclictest.h"
#include "bench/runtime_live_bus.h"
#include "bench/runtime_walk.h"
#include "hal/error.h"
#include "runtime/real_time.h"
#include "runtime/threads.h"
#include "tests/source_dir/source_dir.h"

namespace headway::bench {
namespace {

struct Options {
  int seconds = 120, runs = 5;
};
Options options;

double us(Duration d) { return 1e6 * to_seconds(d); }

/// The value that a share of all is not above; nearest rank.
double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values.at(std::max<std::size_t>(rank, 1) - 1);
}
double median(const std::vector<double>& values) { return quantile(values, 0.5); }

int last_processor() { return static_cast<int>(::sysconf(_SC_NPROCESSORS_ONLN)) - 1; }

runtime::RealTime urgent() {
  return {.want = runtime::RealTime::Want::kEnforce, .bus_processor = last_processor()};
}

app::Robot robot() { return app::read_robot(source_dir() / "config/hrp2/robot.yaml"); }

void show(const char* who, int run, Duration p50, Duration p99, Duration p999, Duration max,
          std::uint64_t missed, std::uint64_t count) {
  std::printf("%-10s run %d: wake-up p50 %7.1f  p99 %7.1f  p99.9 %7.1f  max %8.1f us, %llu of %llu missed\n",
              who, run, us(p50), us(p99), us(p999), us(max), static_cast<unsigned long long>(missed),
              static_cast<unsigned long long>(count));
  std::fflush(stdout);
}

struct Totals {
  std::vector<double> ours, theirs;  ///< p99.9 of each run [us]
  std::uint64_t missed = 0, theirs_missed = 0, heap = 0, major = 0;
  Duration run_max{};

  void one_of_ours(int run) {
    LiveBus bus(robot(), urgent());
    hal::MonotonicClock clock;
    clock.sleep_until(clock.now() + seconds(options.seconds));
    const LiveBus::Result result = bus.stop();
    const runtime::Spread& wake = result.times.bus_wake_up;
    show("bus loop", run, wake.p50, wake.p99, wake.p999, wake.max, result.times.missed, wake.count);
    ours.push_back(us(wake.p999));
    missed += result.times.missed;
    heap += result.heap_calls;
    major += result.times.bus_faults.major;
    run_max = std::max(run_max, result.times.bus_run.max);
  }
  void one_of_theirs(int run) {
    const WakeUps wake = cyclictest(seconds(0.005), runtime::kind(runtime::ThreadId::kBus).priority,
                                    last_processor(), seconds(options.seconds));
    show("cyclictest", run, wake.p50, wake.p99, wake.p999, wake.max, wake.missed, wake.count);
    theirs.push_back(us(wake.p999));
    theirs_missed += wake.missed;
  }
};

void bus_cycle(benchmark::State& state) {
  for (auto _ : state) {
    Totals totals;
    const Load load(last_processor());
    for (int run = 1; run <= options.runs; ++run) {
      totals.one_of_ours(run);
      totals.one_of_theirs(run);
    }
    figure("wake_p999_us", median(totals.ours));
    figure("cyclictest_p999_us", median(totals.theirs));
    figure("wake_p999_ratio_cyclictest", median(totals.ours) / median(totals.theirs));
    figure("missed_cycles", static_cast<double>(totals.missed));
    figure("cyclictest_missed", static_cast<double>(totals.theirs_missed));
    figure("heap_calls", static_cast<double>(totals.heap));
    figure("major_faults", static_cast<double>(totals.major));
    figure("run_max_us", us(totals.run_max));
  }
}
BENCHMARK(bus_cycle)->Iterations(1)->Unit(benchmark::kSecond);

/// Of the frames on the way back.
struct FrameTimes {
  std::vector<double> total, cpu, see, map, floor, plan;  ///< [ms]
  void add(const PlayedWalk& walk) {
    const auto ms = [](Duration d) { return 1e3 * to_seconds(d); };
    const runtime::StageTimes& stages = walk.stages();
    total.push_back(1e3 * walk.seconds());
    cpu.push_back(1e3 * walk.cpu_seconds());
    see.push_back(ms(stages.see));
    map.push_back(ms(stages.map));
    floor.push_back(ms(stages.floor));
    plan.push_back(ms(stages.plan));
  }
  void tell() const {
    const auto show = [](const char* name, const std::string& key, const std::vector<double>& values) {
      std::printf("%-6s n %zu  p50 %6.2f  p99 %6.2f  max %6.2f ms\n", name, values.size(),
                  quantile(values, 0.5), quantile(values, 0.99), quantile(values, 1));
      figure(key + "_p50_ms", quantile(values, 0.5));
      figure(key + "_p99_ms", quantile(values, 0.99));
    };
    show("see", "frame_see", see);
    show("map", "frame_map", map);
    show("floor", "frame_floor", floor);
    show("plan", "frame_plan", plan);
    show("whole", "frame", total);
    show("cpu", "frame_cpu", cpu);
    figure("frames", static_cast<double>(total.size()));
  }
};

void frame(benchmark::State& state) {
  static const RecordedWalk walk = record_walk();
  std::printf("%zu frames recorded, on the way back from number %zu on\n", walk.frames.size(), walk.turned);
  std::fflush(stdout);
  for (auto _ : state) {
    LiveBus bus(robot(), urgent());
    FrameTimes times;
    PlayedWalk played(walk);
    hal::MonotonicClock clock;
    for (Time next = clock.now(); !played.over(); next += seconds(1 / walk.frame_rate)) {
      clock.sleep_until(next);
      played.work();
      if (played.walks_back()) times.add(played);
    }
    const LiveBus::Result result = bus.stop();
    times.tell();
    figure("frame_replans", played.counters().replans);
    figure("frame_plans", played.counters().plans);
    figure("frame_bus_missed", static_cast<double>(result.times.missed));
    figure("frame_bus_wake_p999_us", us(result.times.bus_wake_up.p999));
  }
}
BENCHMARK(frame)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace headway::bench

int main(int argc, char** argv) {
  using namespace headway;
  try {
    bench::options.seconds = bench::take(argc, argv, "--seconds", bench::options.seconds);
    bench::options.runs = bench::take(argc, argv, "--runs", bench::options.runs);
    cv::setNumThreads(1);
    runtime::lock_memory(bench::urgent());
    return bench::run(argc, argv);
  } catch (const Error& fault) {
    std::fprintf(stderr, "%s: %s\n", argv[0], fault.what());
    return 1;
  }
}
