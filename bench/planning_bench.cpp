// How fast and how good the planner is on real floors, beside the textbook's A* on the same 72 configurations
// and costs: in one run, on one core, Highway held to AVX2. Every path is walked again.
//
// Times are CPU time, of each errand the least of kRounds. Cold: a map never seen before, to the optimum.
// Warm: a map that differs from the last one by a patch of 0.5 x 0.5 m, which came onto the path some 2 m
// ahead or went away again, to a path within 1.0625 of the optimum. Both hold all that is done with the map:
// masks, prices, search, path. So do the textbook's, which looks at masks and prices of the cells it comes
// to. The planner has no second thread: what it takes with two cores is what it takes with one.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/cpu_time.h"
#include "bench/figures.h"
#include "bench/hold_to_avx2.h"
#include "bench/planning_floors.h"
#include "nav/planner.h"
#include "tests/nav/textbook_search.h"

namespace headway {
namespace {

using namespace bench;
using Eigen::Vector2i;

constexpr int kErrands = 200;
constexpr int kRounds = 3;
constexpr std::uint32_t kSeed = 2006;

class Samples {
 public:
  void add(double value) { values_.push_back(value); }
  /// The value below which a share of them lies.
  double share(double of) {
    std::sort(values_.begin(), values_.end());
    return values_.empty()
               ? 0
               : values_[std::min(values_.size() - 1,
                                  static_cast<std::size_t>(of * static_cast<double>(values_.size())))];
  }
  double mean() const {
    double sum = 0;
    for (const double v : values_) sum += v;
    return values_.empty() ? 0 : sum / static_cast<double>(values_.size());
  }
  void show(const std::string& floor, const char* what) {
    std::printf("%-8s %-44s n %3zu  median %9.3f  mean %9.3f  p99 %9.3f  worst %9.3f\n", floor.c_str(), what,
                values_.size(), share(0.5), mean(), share(0.99), share(1));
  }

 private:
  std::vector<double> values_;
};

/// A start with a heading of the planner's, and a goal.
struct Errand {
  Pose2 start;
  nav::Goal goal;
};

nav::PlannerConfig textbook_config() {
  nav::PlannerConfig config;
  config.start_is_free = false;  // the textbook knows of no such thing
  return config;
}

class Building {
 public:
  Building(std::string name, const nav::FloorMap& map)
      : name_(std::move(name)),
        map_(map),
        planner_(textbook_config(), {}, {}, map.grid),
        quick_(quick_config(), {}, {}, map.grid),
        textbook_(map, textbook_config(), {}, planner_.masks()) {}

  /// Errands between random places where every motion is free, more than 0.4 of the map apart.
  void run(int textbook_every) {
    std::printf("%s: %d x %d cells of %.3f m, %d errands of seed %u\n", name_.c_str(), map_.grid.width,
                map_.grid.height, map_.grid.resolution, kErrands, kSeed);
    const std::vector<Vector2i> places = open_places();
    std::mt19937 dice(kSeed);
    for (int done = 0, tried = 0; done < kErrands; ++tried) {
      if (tried > 100 * kErrands) throw std::runtime_error(name_ + ": too few errands that can be done");
      const Vector2i from = places[dice() % places.size()], to = places[dice() % places.size()];
      const double heading = nav::heading_angle(static_cast<int>(dice() % 8));
      if ((to - from).cast<double>().norm() <= 0.4 * std::max(map_.grid.width, map_.grid.height)) continue;
      const Eigen::Vector2d start = map_.grid.centre(from);
      if (do_errand({{start.x(), start.y(), heading}, {map_.grid.centre(to), std::nullopt, 0}},
                    done % textbook_every == 0))
        ++done;
    }
  }

  void report() {
    cold_.show(name_, "cold, optimal [ms]");
    first_.show(name_, "cold, within 1.0625 [ms]");
    came_.show(name_, "warm, a patch came [ms]");
    went_.show(name_, "warm, a patch went [ms]");
    warm_.show(name_, "warm, both [ms]");
    warm_optimal_.show(name_, "warm, optimal, a patch came [ms]");
    textbook_times_.show(name_, "the textbook's A* [ms]");
    work_.show(name_, "chunks worked on, cold and optimal");
    plan_seconds_.show(name_, "cost of the path [s]");
    std::printf(
        "%-8s ratio %.1f, worst bound %.4f, memory %.1f MB, %d errands without a way, %d patches that closed "
        "it\n",
        name_.c_str(), ratio(), worst_bound_, memory_mb(), unreachable_, closed_);
    if (faults_ > 0) throw std::runtime_error(name_ + ": paths or costs are wrong");
  }

  double ratio() const { return textbook_times_.mean() / cold_of_textbook_.mean(); }
  double worst_bound() const { return worst_bound_; }
  double memory_mb() const { return 1e-6 * static_cast<double>(planner_.bytes()); }
  Samples& cold() { return cold_; }
  Samples& warm() { return warm_; }
  Samples& came() { return came_; }
  Samples& went() { return went_; }

 private:
  static nav::PlannerConfig quick_config() {
    nav::PlannerConfig config = textbook_config();
    config.budget = 0;
    return config;
  }

  std::vector<Vector2i> open_places() const {
    std::vector<Vector2i> places;
    for (int y = 0; y < map_.grid.height; ++y) {
      for (int x = 0; x < map_.grid.width; ++x) {
        bool open = true;
        for (int c = 0; open && c < nav::kConfigurations; ++c)
          open = !textbook_.blocked({x, y}, {c / nav::kMotions, c % nav::kMotions});
        if (open) places.push_back({x, y});
      }
    }
    return places;
  }

  bool do_errand(const Errand& e, bool with_textbook) {
    LeastTime cold, first;
    nav::PlanResult best, quick;
    for (int round = 0; round < kRounds; ++round) {
      planner_.forget();
      cold.take([&] { best = planner_.plan(map_, e.start, e.goal); });
      if (!best) {
        ++unreachable_;
        return false;
      }
      quick_.forget();
      first.take([&] { quick = quick_.plan(map_, e.start, e.goal); });
    }
    check(best, textbook_, e);
    check(quick, textbook_, e);
    faults_ += best.bound != 1;
    worst_bound_ = std::max(worst_bound_, quick.path.cost_s / best.path.cost_s);
    cold_.add(1e3 * cold.seconds());
    first_.add(1e3 * first.seconds());
    work_.add(static_cast<double>(best.expansions));
    plan_seconds_.add(best.path.cost_s);
    if (with_textbook) {
      const double before = cpu_seconds();
      nav::TextbookSearch anew(map_, textbook_config(), {}, planner_.masks());
      const std::uint32_t cost = anew.cost(e.start, e.goal);
      textbook_times_.add(1e3 * (cpu_seconds() - before));
      cold_of_textbook_.add(1e3 * cold.seconds());
      faults_ += std::abs(cost * textbook_.tick() - best.path.cost_s) > 1e-6;
    }
    replan(e, best);
    return true;
  }

  void replan(const Errand& e, const nav::PlanResult& best) {
    const auto& states = best.path.states;
    if (states.size() < 70) return;
    const Vector2i ahead = states[std::min<std::size_t>(states.size() - 25, 45)].cell;
    nav::FloorMap patched = map_;
    for (int y = ahead.y() - 5; y < ahead.y() + 5; ++y)
      for (int x = ahead.x() - 5; x < ahead.x() + 5; ++x)
        if (map_.grid.contains({x, y})) patched.cells[map_.grid.index({x, y})] = nav::Floor::kBlocked;
    LeastTime came, went, optimal;
    nav::PlanResult with, without, with_best;
    for (int round = 0; round < kRounds; ++round) {
      came.take([&] { with = quick_.plan(patched, e.start, e.goal); });
      went.take([&] { without = quick_.plan(map_, e.start, e.goal); });
      optimal.take([&] { with_best = planner_.plan(patched, e.start, e.goal); });
      planner_.plan(map_, e.start, e.goal);
    }
    worst_bound_ = std::max(worst_bound_, without.path.cost_s / best.path.cost_s);
    check(without, textbook_, e);
    faults_ += static_cast<bool>(with) != static_cast<bool>(with_best);
    if (!with) {
      ++closed_;
      return;
    }
    worst_bound_ = std::max(worst_bound_, with.path.cost_s / with_best.path.cost_s);
    faults_ += meets_something(with.path, patched) || meets_something(with_best.path, patched);
    for (const LeastTime* t : {&came, &went}) warm_.add(1e3 * t->seconds());
    came_.add(1e3 * came.seconds());
    went_.add(1e3 * went.seconds());
    warm_optimal_.add(1e3 * optimal.seconds());
  }

  /// Whether the body's mask, in any motion of a path, touches a blocked cell.
  bool meets_something(const nav::Path& path, const nav::FloorMap& floor) const {
    const auto blocked = [&](const Vector2i& cell) {
      return !floor.grid.contains(cell) || floor.at(cell) == nav::Floor::kBlocked;
    };
    for (std::size_t i = 1; i < path.states.size(); ++i) {
      const nav::PathState &a = path.states[i - 1], &b = path.states[i];
      for (int number = 0; number < nav::kMotions; ++number) {
        const nav::Motion m{a.heading, number};
        if (m.mode() != b.mode || m.heading_after() != b.heading ||
            a.cell + nav::cell_towards(m.direction()) != b.cell)
          continue;
        for (const nav::Mask::Run& run : planner_.masks().of(m).runs)
          for (int x = run.first; x <= run.last; ++x)
            if (blocked(a.cell + Vector2i(x, run.dy))) return true;
      }
    }
    return false;
  }

  /// Walks a path again: each state is one free motion or a change of mode from the last, and costs what it
  /// should.
  void check(const nav::PlanResult& result, const nav::TextbookSearch& textbook, const Errand& e) {
    const auto& states = result.path.states;
    const auto& cost = result.path.cost_so_far_s;
    bool good = result && states.front().cell == map_.grid.cell(e.start.position()) &&
                states.back().cell == map_.grid.cell(e.goal.position);
    double so_far = textbook.turn(nav::heading_angle(states.front().heading) - e.start.yaw) * textbook.tick();
    for (std::size_t i = 1; good && i < states.size(); ++i) {
      const nav::PathState &a = states[i - 1], &b = states[i];
      std::optional<std::uint32_t> step;
      if (a.cell == b.cell && a.heading == b.heading && a.mode != b.mode) step = textbook.mode_change();
      for (int number = 0; number < nav::kMotions; ++number) {
        const nav::Motion m{a.heading, number};
        if (m.mode() == a.mode && a.mode == b.mode && m.heading_after() == b.heading &&
            a.cell + nav::cell_towards(m.direction()) == b.cell && !textbook.blocked(a.cell, m))
          step = textbook.motion(a.cell, m);
      }
      good = step.has_value();
      so_far += step.value_or(0) * textbook.tick();
      good = good && std::abs(so_far - cost[i]) < 1e-6;
    }
    faults_ += !good || std::abs(so_far - result.path.cost_s) > 1e-6;
  }

  std::string name_;
  const nav::FloorMap& map_;
  nav::Planner planner_, quick_;
  nav::TextbookSearch textbook_;
  Samples cold_, first_, came_, went_, warm_, warm_optimal_, textbook_times_, cold_of_textbook_, work_,
      plan_seconds_;
  double worst_bound_ = 1;
  int unreachable_ = 0, closed_ = 0, faults_ = 0;
};

double worst_bound = 1;

/// 218 x 237 cells of 5 cm.
void cubicle(benchmark::State& state) {
  const nav::FloorMap map = read_floor("cubicle-25mm-inflated-env");
  for (auto _ : state) {
    Building building("cubicle", map);
    building.run(1);
    building.report();
    worst_bound = std::max(worst_bound, building.worst_bound());
    state.counters["cubicle_warm_p99_ms"] = building.warm().share(0.99);
    state.counters["cubicle_came_p99_ms"] = building.came().share(0.99);
    state.counters["cubicle_went_p99_ms"] = building.went().share(0.99);
    state.counters["cubicle_cold_median_ms"] = building.cold().share(0.5);
    state.counters["ratio_textbook_cubicle"] = building.ratio();
  }
}

/// 974 x 1106 cells of 5 cm. The textbook takes seconds for one errand: it does every tenth.
void willow(benchmark::State& state) {
  const nav::FloorMap map = read_floor("willow-25mm-inflated-env");
  for (auto _ : state) {
    Building building("willow", map);
    building.run(10);
    building.report();
    worst_bound = std::max(worst_bound, building.worst_bound());
    state.counters["willow_warm_median_ms"] = building.warm().share(0.5);
    state.counters["willow_warm_worst_ms"] = building.warm().share(1);
    // The same figure: see above.
    state.counters["willow_warm_worst_2core_ms"] = building.warm().share(1);
    state.counters["willow_came_median_ms"] = building.came().share(0.5);
    state.counters["willow_went_median_ms"] = building.went().share(0.5);
    state.counters["willow_cold_median_ms"] = building.cold().share(0.5);
    state.counters["ratio_textbook_willow"] = building.ratio();
    state.counters["willow_memory_mb"] = building.memory_mb();
    state.counters["bound_max"] = worst_bound;
  }
}

BENCHMARK(cubicle)->Iterations(1)->Unit(benchmark::kSecond);
BENCHMARK(willow)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace headway

int main(int argc, char** argv) {
  headway::bench::fact("highway_target", headway::bench::hold_to_avx2());
  return headway::bench::run(argc, argv);
}
