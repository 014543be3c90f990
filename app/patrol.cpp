#include "app/patrol.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

namespace headway::app {

namespace {

/// Of what `get` gives for laps [from, to); 0 of none.
template <class Get>
double median(const std::vector<Lap>& laps, std::size_t from, std::size_t to, Get get) {
  std::vector<double> values;
  for (std::size_t i = from; i < to; ++i) values.push_back(static_cast<double>(get(laps[i])));
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <class Get>
double growth(const std::vector<Lap>& laps, Get get) {
  const std::size_t quarter = laps.size() / 4;
  return median(laps, laps.size() - quarter, laps.size(), get) - median(laps, quarter, 2 * quarter, get);
}

}  // namespace

Holdings holdings_now() {
  const struct mallinfo2 heap = ::mallinfo2();
  std::size_t size = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> size >> pages;
  const std::filesystem::directory_iterator open("/proc/self/fd");
  return {heap.uordblks + heap.hblkhd, pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)),
          static_cast<int>(std::distance(begin(open), end(open)))};
}

Endurance endurance_of(const std::vector<Lap>& laps) {
  Endurance found;
  found.laps = laps.size();
  if (laps.empty()) return found;
  for (const Lap& lap : laps) found.hours += lap.seconds / 3600;
  found.heap_growth = growth(laps, [](const Lap& lap) { return lap.after.heap; });
  found.map_drift = growth(laps, [](const Lap& lap) { return lap.outcome.map_error; });
  for (const Lap& lap : laps) {
    found.arrived += lap.outcome.arrived;
    found.most_descriptors = std::max(found.most_descriptors, lap.after.descriptors);
  }
  found.descriptors_growth = found.most_descriptors - laps.front().after.descriptors;
  return found;
}

std::vector<std::string> Endurance::complaints() const {
  std::vector<std::string> all;
  if (laps < 8) all.push_back(fmt::format("{} laps are too few to tell; more --hours", laps));
  if (arrived < laps)
    all.push_back(fmt::format("{} of {} laps did not end at their goal", laps - arrived, laps));
  if (heap_growth > kHeapMayGrow)
    all.push_back(fmt::format("the heap grew by {:.2f} MiB", heap_growth / (1 << 20)));
  if (descriptors_growth > 0) all.push_back(fmt::format("{} descriptors more are open", descriptors_growth));
  if (map_drift > kMapMayDrift) all.push_back(fmt::format("the map's error grew by {:.3f} m", map_drift));
  return all;
}

std::vector<Lap> patrol(SimSession& session, const std::vector<nav::Goal>& goals, Duration longest,
                        const std::function<void(const Lap&)>& after_each) {
  std::vector<Lap> laps;
  const Time end = session.now() + longest;
  while (session.now() < end) {
    const Time begin = session.now();
    session.send_to(goals[laps.size() % goals.size()]);
    laps.push_back({session.run(), to_seconds(session.now() - begin), holdings_now()});
    after_each(laps.back());
    if (laps.back().outcome.fallen || laps.back().outcome.collision) break;
  }
  return laps;
}

Json patrol_report(const std::vector<Lap>& laps, const Endurance& endurance) {
  Json rows = Json::array();
  for (const Lap& lap : laps)
    rows.push_back({{"end", lap.outcome.end},
                    {"reason", lap.outcome.reason},
                    {"simulated_s", rounded(lap.seconds, 2)},
                    {"goal_error_m", rounded(lap.outcome.goal_error)},
                    {"map_error_m", rounded(lap.outcome.map_error)},
                    {"odometry_error_m", rounded(lap.outcome.odometry_error)},
                    {"heap_bytes", lap.after.heap},
                    {"resident_bytes", lap.after.resident},
                    {"descriptors", lap.after.descriptors}});
  return {{"laps", endurance.laps},
          {"arrived", endurance.arrived},
          {"simulated_hours", rounded(endurance.hours, 3)},
          {"heap_growth_bytes", rounded(endurance.heap_growth, 0)},
          {"map_drift_m", rounded(endurance.map_drift)},
          {"descriptors_growth", endurance.descriptors_growth},
          {"complaints", endurance.complaints()},
          {"rows", rows}};
}

}  // namespace headway::app
