#include "app/walk_cost.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

namespace headway::app {
namespace {

constexpr double kMebibyte = 1 << 20;

double mebibytes(std::size_t bytes) { return static_cast<double>(bytes) / kMebibyte; }

/// As the kernel counts it; 0 where it does not say.
double resident_mebibytes() {
  std::ifstream statm("/proc/self/statm");
  double all = 0, resident = 0;
  if (!(statm >> all >> resident)) return 0;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / kMebibyte;
}

double ms(Duration d) { return to_seconds(d) * 1e3; }

}  // namespace

void WalkCost::note(const runtime::FrameSnapshot& snapshot, double walked) {
  worst_ = std::max(worst_, snapshot.times.total());
  if (walked < stretch_ * static_cast<double>(stretches_.size() + 1)) return;
  const nav::ColdMap& aside = snapshot.mapper.aside();
  stretches_.push_back(
      {walked, snapshot.mapper.voxels().bytes(), aside.bytes(), aside.size(), resident_mebibytes(), worst_});
  worst_ = {};
}

Json walk_cost_report(const std::vector<WalkStretch>& stretches) {
  Json rows = Json::array();
  for (const WalkStretch& s : stretches)
    rows.push_back({{"walked_m", rounded(s.walked, 2)},
                    {"window_mib", rounded(mebibytes(s.window_bytes), 2)},
                    {"aside_mib", rounded(mebibytes(s.aside_bytes), 2)},
                    {"bricks_aside", s.aside_bricks},
                    {"resident_mib", rounded(s.resident_mib, 1)},
                    {"worst_frame_ms", rounded(ms(s.worst_frame), 2)}});
  return rows;
}

std::string walk_cost_table(const std::vector<WalkStretch>& stretches) {
  std::string table;
  for (const WalkStretch& s : stretches)
    table += fmt::format(
        "{:6.1f} m: window {:.1f} MiB, aside {:.2f} MiB in {} bricks, program {:.0f} MiB, worst frame {:.1f} "
        "ms\n",
        s.walked, mebibytes(s.window_bytes), mebibytes(s.aside_bytes), s.aside_bricks, s.resident_mib,
        ms(s.worst_frame));
  return table;
}

}  // namespace headway::app
