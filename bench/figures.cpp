#include "bench/figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sched.h>

namespace headway::bench {

namespace {

struct Figures {
  std::map<std::string, double> by_hand, values;
  std::map<std::string, std::string> facts;
  std::vector<std::string> faults;

  void add(const std::string& key, double value) {
    if (!std::isfinite(value)) faults.push_back(fmt::format("figure '{}' is {}", key, value));
    if (!values.emplace(key, value).second) faults.push_back(fmt::format("figure '{}' stands twice", key));
  }
};

Figures& figures() {
  static Figures all;
  return all;
}

std::string key_of(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

// Shows the runs, keeps Google Benchmark's JSON, and takes the figures out of them.
class Reporter final : public benchmark::BenchmarkReporter {
 public:
  Reporter() { json_.SetOutputStream(&json_text_); }

  bool ReportContext(const Context& context) override {
    return console_.ReportContext(context) && json_.ReportContext(context);
  }

  void ReportRuns(const std::vector<Run>& runs) override {
    console_.ReportRuns(runs);
    json_.ReportRuns(runs);
    for (const Run& run : runs) take(run);
  }

  void Finalize() override {
    console_.Finalize();
    json_.Finalize();
  }

  std::string json_text() const { return json_text_.str(); }

 private:
  void take(const Run& run) {
    const std::string name =
        run.run_name.function_name + (run.run_name.args.empty() ? "" : "/" + run.run_name.args);
    if (run.error_occurred) {
      figures().faults.push_back(fmt::format("{}: {}", name, run.error_message));
      return;
    }
    // Of repetitions only the median counts; it comes after them.
    const bool median = run.run_type == Run::RT_Aggregate && run.aggregate_name == "median";
    if (run.repetitions > 1 ? !median : run.run_type != Run::RT_Iteration) return;
    figures().add(key_of(name) + "_" + benchmark::GetTimeUnitString(run.time_unit),
                  run.GetAdjustedRealTime());
    for (const auto& [counter, value] : run.counters) figures().add(counter, value.value);
  }

  benchmark::ConsoleReporter console_{benchmark::ConsoleReporter::OO_Tabular};
  benchmark::JSONReporter json_;
  std::ostringstream json_text_;
};

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(": ") + 2));
  return "unknown";
}

std::string best_instruction_set() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw")) return "avx512";
  if (__builtin_cpu_supports("avx2")) return "avx2";
  if (__builtin_cpu_supports("sse4.2")) return "sse4.2";
  return "sse2";
#elif defined(__aarch64__)
  return "neon";
#else
  return "unknown";
#endif
}

int usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

nlohmann::json machine_facts() {
  return {
    {"processor", processor_name()}, {"instruction_set", best_instruction_set()}, {"cores", usable_cores()}, {
      "compiler", fmt::format("{} {}",
#if defined(__clang__)
                              "clang",
#else
                              "gcc",
#endif
                              __VERSION__)
    }
    ,
#if defined(__OPTIMIZE__)
    {
      "optimised", true
    }
  };
#else
    {
      "optimised", false
    }
  };
#endif
}

bool write_report(const std::string& file, const std::string& google_json) {
  nlohmann::json report = google_json.empty() ? nlohmann::json::object() : nlohmann::json::parse(google_json);
  // Names one machine rather than a kind of machine.
  if (report.contains("context")) report["context"].erase("host_name");
  report["machine"] = machine_facts();
  for (const auto& [key, value] : figures().facts) report["machine"][key] = value;
  report["figures"] = figures().values;
  std::ofstream out(file);
  out << report.dump(2) << '\n';
  return static_cast<bool>(out.flush());
}

// Takes `--out FILE` (or --out=FILE) away from Google Benchmark's arguments.
std::string take_out_argument(int& argc, char** argv) {
  std::string file;
  int kept = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--out" && i + 1 < argc)
      file = argv[++i];
    else if (argument.starts_with("--out="))
      file = argument.substr(6);
    else
      argv[kept++] = argv[i];
  }
  argc = kept;
  return file;
}

}  // namespace

void figure(const std::string& key, double value) { figures().by_hand[key] = value; }

void fact(const std::string& key, const std::string& value) { figures().facts[key] = value; }

int run(int argc, char** argv) {
  const std::string file = take_out_argument(argc, argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  Reporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  benchmark::Shutdown();
  for (const auto& [key, value] : figures().by_hand) figures().add(key, value);
  for (const std::string& fault : figures().faults) fmt::print(stderr, "{}: {}\n", argv[0], fault);
  if (!file.empty() && !write_report(file, reporter.json_text())) {
    fmt::print(stderr, "{}: cannot write {}\n", argv[0], file);
    return 1;
  }
  return figures().faults.empty() ? 0 : 1;
}

}  // namespace headway::bench
