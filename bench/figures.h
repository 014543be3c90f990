// The main program of every benchmark. It runs what is registered with Google Benchmark and writes one JSON
// file: Google Benchmark's own report, the machine's facts, and one flat object `figures` of named numbers.
//
// A program is its benchmarks and one last line:
//   void match_640(benchmark::State& state) { for (auto _ : state) ...; }
//   BENCHMARK(match_640)->Unit(benchmark::kMillisecond);
//   HEADWAY_BENCHMARK_MAIN()
#pragma once

#include <string>

#include <benchmark/benchmark.h>

namespace headway::bench {

/// Writes down one figure by hand: what is counted rather than timed, or taken from many runs (a percentile).
/// The key says the unit: "frame_ms_p99", "map_mb", "coverage". May be called again, as Google Benchmark
/// calls a benchmark several times; the last value counts.
void figure(const std::string& key, double value);

/// Adds to the machine's facts in the report: what a benchmark chose of what the machine offers.
void fact(const std::string& key, const std::string& value);

/// Runs the benchmarks. `--out FILE` names the JSON file; all else goes to Google Benchmark (see --help).
/// Figures are: those of `figure`; each counter of a benchmark, under the counter's name; and each
/// benchmark's wall time per iteration as NAME_ns, NAME_us, NAME_ms or NAME_s, by its unit (the median, when
/// it is repeated; "/" in a name becomes "_"). Returns the program's exit code: 1 when a benchmark failed, a
/// key stands twice, a value is not finite, or the file cannot be written.
int run(int argc, char** argv);

}  // namespace headway::bench

#define HEADWAY_BENCHMARK_MAIN() \
  int main(int argc, char** argv) { return headway::bench::run(argc, argv); }
