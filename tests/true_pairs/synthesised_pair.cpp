// One image with depths becomes a pair: its pixels are drawn where a second camera would see them. What only
// that camera sees, beside near things, shows what lies behind them, stretched.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>

#include <opencv2/imgcodecs.hpp>

#include "tests/true_pairs/true_pairs.h"

namespace headway {

namespace {

constexpr double kFocal = 481.2, kBaseline = 0.144;  // [px], [m]
constexpr double kUnits = 5000;                      // of the depth image to the metre

/// One row as the right camera sees it: between two neighbours their grey values run evenly, the nearer hides
/// the farther. The gap that a step leaves belongs to its farther side.
std::vector<float> row_from_right(const std::uint8_t* grey, const float* disparity, int width) {
  const auto size = static_cast<std::size_t>(width);
  // Beyond what the left camera shows, its last pixel goes on.
  std::vector<float> out(size, static_cast<float>(grey[width - 1])), nearest(size, 0);
  for (int u = 0; u + 1 < width; ++u) {
    const float here = disparity[u], next = disparity[u + 1];
    const float from = static_cast<float>(u) - here, to = static_cast<float>(u + 1) - next;
    if (!(from < to)) continue;  // turned away, or not known
    const bool step = std::abs(next - here) > 1;
    for (int x = std::max(0, static_cast<int>(std::ceil(from))); x < width && static_cast<float>(x) < to;
         ++x) {
      const float even = (static_cast<float>(x) - from) / (to - from);
      const float share = step ? (next < here ? 1.0F : 0.0F) : even;
      const float d = std::lerp(here, next, share);
      const auto i = static_cast<std::size_t>(x);
      if (d < nearest[i]) continue;
      nearest[i] = d;
      out[i] = std::lerp(static_cast<float>(grey[u]), static_cast<float>(grey[u + 1]), share);
    }
  }
  return out;
}

}  // namespace

std::vector<TruePair> synthesised_pairs() {
  const char* data = std::getenv("HEADWAY_DATA");
  const std::filesystem::path folder = std::filesystem::path(data ? data : "") / "sequence" / "iclnuim";
  const cv::Mat1b grey(cv::imread((folder / "rgb/1.png").string(), cv::IMREAD_GRAYSCALE));
  const cv::Mat1w depth(cv::imread((folder / "depth/1.png").string(), cv::IMREAD_UNCHANGED));
  if (grey.empty() || grey.size() != depth.size()) return {};
  TruePair pair{"living_room", 0, {grey.cols, grey.rows, {}}, {grey.cols, grey.rows, {}}, {}, {}};
  pair.truth.resize(grey.cols, grey.rows);
  for (int v = 0; v < grey.rows; ++v)
    for (int u = 0; u < grey.cols; ++u)
      if (depth(v, u) > 0)
        pair.truth.values[pair.truth.index(u, v)] =
            static_cast<float>(kFocal * kBaseline * kUnits / depth(v, u));
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 2);
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u)
      pair.left.pixels.push_back(
          cv::saturate_cast<std::uint8_t>(static_cast<float>(grey(v, u)) + noise(random)));
    for (const float value :
         row_from_right(grey[v], pair.truth.values.data() + pair.truth.index(0, v), grey.cols))
      pair.right.pixels.push_back(cv::saturate_cast<std::uint8_t>(value + noise(random)));
  }
  pair.right_askew = half_a_row_lower(pair.right);
  search_all(pair);
  leave_out_first_columns(pair);
  return {pair};
}

}  // namespace headway
