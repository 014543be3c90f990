#include "vision/census_matcher.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "hal/error.h"
#include "vision/ambiguity.h"
#include "vision/cv_image.h"

namespace headway::vision {

namespace {

constexpr int kUnit = 16;  // fixed-point disparities: 16 to the pixel
constexpr float kEnoughRivals = 16;

void require(bool good, const char* key, double value, const char* expected) {
  if (!good) throw InputError(fmt::format("census matcher: {}: {:g}, expected {}", key, value, expected));
}

void check(DisparityRange range, const CensusConfig& c) {
  require(range.count > 0 && range.count % 16 == 0 && range.count <= Sgm::kMostDisparities, "disparities",
          range.count,
          "a multiple of 16 up to 256 (choose the matcher sgbm, or a rig that need not see so near)");
  require(std::abs(range.lowest) <= 2048, "lowest disparity", range.lowest, "-2048 to 2048");
  const SgmPenalties& p = c.penalties;
  require(p.p1 >= 0 && p.p1 <= p.p2_least, "p1", p.p1, "0 to p2_least");
  require(p.p2_least <= p.p2, "p2_least", p.p2_least, "at most p2");
  require(p.p2 <= Sgm::kLargestP2, "p2", p.p2, "at most 90");
  require(p.p2_edge >= 1 && p.p2_edge <= 10000, "p2_edge", p.p2_edge, "1 to 10000");
  require(p.paths == 3 || p.paths == 4, "paths", p.paths, "3 or 4");
  require(c.left_right_difference >= 0 && c.left_right_difference < SgmResult::kOutside,
          "left_right_difference", c.left_right_difference, "0 to 254");
  require(c.most_ambiguous > 0 && c.most_ambiguous <= 1, "most_ambiguous", c.most_ambiguous,
          "above 0, up to 1");
  require(c.speckle_size >= 0, "speckle_size", c.speckle_size, "0 or more");
  require(c.speckle_range >= 0 && c.speckle_range <= 256, "speckle_range", c.speckle_range, "0 to 256");
}

/// Where the search leaves out what OpenCV leaves out, columns from the first to before the end; none in
/// narrow images.
SgmSearch search_in(const hal::GrayImage& image, DisparityRange range, bool borders) {
  SgmSearch s{image.width, image.height, range.lowest, range.count, 0, image.width};
  if (borders) return s;
  s.first_column = std::clamp(range.lowest + range.count, 0, image.width);
  s.end_column = std::clamp(image.width + std::min(0, range.lowest), s.first_column, image.width);
  return s;
}

}  // namespace

CensusMatcher::CensusMatcher(DisparityRange range, const CensusConfig& config, hal::TwoProcessors& processors)
    : range_(range), config_(config), processors_(processors) {
  check(range, config);
}

void CensusMatcher::match(const hal::GrayImage& left, const hal::GrayImage& right, DisparityImage& out) {
  out.resize(left.width, left.height);
  if (!complete(left) || !complete(right) || left.width != right.width || left.height != right.height) return;
  sgm_.match(search_in(left, range_, config_.borders), config_.penalties, left, right, processors_, found_);
  smooth_.resize(found_.disparity.size());
  median_3x3(left.width, left.height, found_.disparity.data(), smooth_.data());
  for (std::size_t i = 0; i < smooth_.size(); ++i)
    if (found_.disagreement[i] > config_.left_right_difference) smooth_[i] = SgmResult::kNone;
  speckles_.drop(left.width, left.height, config_.speckle_size,
                 static_cast<int>(std::lround(config_.speckle_range * kUnit)), SgmResult::kNone,
                 smooth_.data());
  weigh_columns(left.width);
  write(out);
}

/// For each column how little it says to win there: more the fewer rivals the border of the right image
/// leaves.
void CensusMatcher::weigh_columns(int width) {
  alone_.resize(static_cast<std::size_t>(width));
  for (int u = 0; u < width; ++u) {
    const int reach = u - range_.lowest;  // the index of the disparity that leads to column 0
    const int rivals = std::min(reach + 1, range_.count) - std::max(reach - (width - 1), 0);
    alone_[static_cast<std::size_t>(u)] = std::max(0.0F, 1 - static_cast<float>(rivals) / kEnoughRivals);
  }
}

void CensusMatcher::write(DisparityImage& out) const {
  out.ambiguity.resize(out.values.size());
  AmbiguityRules rules;
  rules.lowest = static_cast<float>(range_.lowest);
  rules.most_ambiguous = static_cast<float>(config_.most_ambiguous);
  for (int v = 0; v < out.height; ++v) {
    const std::size_t row = out.index(0, v);
    write_matches({smooth_.data() + row, found_.least.data() + row, found_.second.data() + row,
                   found_.disagreement.data() + row, alone_.data(), out.width},
                  rules, out.values.data() + row, out.ambiguity.data() + row);
  }
}

}  // namespace headway::vision
