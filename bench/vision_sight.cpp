// How long it takes to judge how the cameras see.
#include <benchmark/benchmark.h>

#include "bench/cpu_time.h"
#include "tests/true_pairs/true_pairs.h"
#include "vision/sight_check.h"

namespace headway::bench {

namespace {

/// sight_ms_per_pair: processor time for one rectified pair of 640 x 480; sight_pieces: how many pieces of it
/// were looked for.
void sight(benchmark::State& state) {
  constexpr int kRounds = 15;
  const TruePair pair = room_pairs().front();
  const vision::RectifiedRig rig{{640, 480, 540, 319.5, 239.5}, 0.144, 0, 0.8, 6};
  LeastTime time;
  vision::SightReport report;
  for (auto _ : state)
    for (int round = 0; round < kRounds; ++round)
      time.take([&] { report = vision::check_sight(pair.left, pair.right, rig); });
  if (!report.findings.empty()) return state.SkipWithError("a healthy pair was found wanting");
  state.counters["sight_ms_per_pair"] = 1e3 * time.seconds();
  state.counters["sight_pieces"] = report.pair.looked_for;
}
BENCHMARK(sight)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace headway::bench
