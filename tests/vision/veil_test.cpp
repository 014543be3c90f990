#include "vision/veil.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/every_target.h"
#include "tests/vision/any_disparities.h"
#include "vision/disparity_sigma.h"

namespace headway::vision {
namespace {

constexpr int kWidth = 60, kHeight = 40;

using OfPixel = std::function<double(int, int)>;

/// What is left of a view whose disparities, and their sigmas if there are any, are functions of the pixel.
RangeView filtered(const OfPixel& disparity_at, const OfPixel& sigma_at = {}) {
  DisparityImage disparity;
  disparity.resize(kWidth, kHeight);
  if (sigma_at) disparity.sigma = disparity.values;
  RangeView view;
  view.camera = {kWidth, kHeight, 500, 30, 20};
  view.depth.resize(disparity.values.size());
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      disparity.values[disparity.index(u, v)] = static_cast<float>(disparity_at(u, v));
      if (sigma_at) disparity.sigma[disparity.index(u, v)] = static_cast<float>(sigma_at(u, v));
      view.depth[view.index(u, v)] = static_cast<float>(72 / disparity_at(u, v));
    }
  view.sigma_depth = view.depth;
  drop_veils(disparity, {}, view);
  return view;
}

std::ptrdiff_t dropped(const RangeView& view) {
  return std::count_if(view.depth.begin(), view.depth.end(), [](float z) { return std::isnan(z); });
}

TEST(Veil, KeepsEveryPointOfAFloorAndOfAWallBesideTheWay) {
  EXPECT_EQ(dropped(filtered([](int, int v) { return 10 + 0.1 * v; })), 0) << "floor 1.4 m below";
  EXPECT_EQ(dropped(filtered([](int u, int) { return 10 + 0.45 * u; })), 0) << "wall 0.32 m beside";
}

TEST(Veil, DropsACurtainBetweenANearThingAndTheBackground) {
  const RangeView view = filtered([](int u, int) { return u < 20 ? 40.0 : u < 40 ? 40.0 - (u - 20) : 20.0; });
  for (int u = 22; u < 38; ++u) EXPECT_TRUE(std::isnan(view.depth[view.index(u, 20)])) << u;
  EXPECT_FALSE(std::isnan(view.depth[view.index(10, 20)]));
  EXPECT_FALSE(std::isnan(view.depth[view.index(50, 20)]));
  EXPECT_TRUE(std::isnan(view.sigma_depth[view.index(30, 20)]));
}

TEST(Veil, KeepsThingsThinnerThanItsReach) {
  const RangeView view = filtered([](int u, int) { return u >= 28 && u < 31 ? 40.0 : 20.0; });
  for (int u = 28; u < 31; ++u) EXPECT_FALSE(std::isnan(view.depth[view.index(u, 20)])) << u;
}

TEST(Veil, DropsAGentleCurtainThatIsTorn) {
  const auto curtain = [](int u, int) {
    return u < 20 ? 25.0 : u == 20 ? std::nan("") : u < 26 ? 25 - 0.4 * (u - 20) : 22.0;
  };
  const RangeView view = filtered(curtain);
  for (int u = 21; u < 23; ++u) EXPECT_TRUE(std::isnan(view.depth[view.index(u, 20)])) << u;
  EXPECT_FALSE(std::isnan(view.depth[view.index(30, 20)]));
}

TEST(Veil, DropsAGentleCurtainThatBendsThoughNoPixelIsMissing) {
  const auto curtain = [](int u, int) { return u < 20 ? 25.0 : u < 26 ? 25 - 0.4 * (u - 20) : 22.6; };
  const RangeView view = filtered(curtain, [](int u, int) { return u == 20 || u == 26 ? 0.6 : 0.2; });
  for (int u = 21; u < 25; ++u) EXPECT_TRUE(std::isnan(view.depth[view.index(u, 20)])) << u;
  EXPECT_FALSE(std::isnan(view.depth[view.index(10, 20)]));
  EXPECT_FALSE(std::isnan(view.depth[view.index(32, 20)]));
}

TEST(Veil, KeepsAWallBesideTheWayWhoseMatchesAreSound) {
  EXPECT_EQ(dropped(filtered([](int u, int) { return 10 + 0.45 * u; }, [](int, int) { return 0.45; })), 0);
}

TEST(Veil, CondemnsNothingBesideWhatIsNotKnown) {
  const RangeView view = filtered([](int u, int) { return u < 30 ? 20.0 : std::nan(""); });
  for (int u = 0; u < 30; ++u) EXPECT_FALSE(std::isnan(view.depth[view.index(u, 20)])) << u;
}

constexpr VeilFilter kAny{.steepest = 0.5, .steepest_torn = 0.25, .widest_whole = 0.5, .reach = 3};

/// Whether the line through pixel `at` of `values` (their sigmas, if any) is too steep: from the first that
/// is known within reach to the last.
bool steep_by_definition(const std::vector<float>& values, const std::vector<float>& sigmas, int at) {
  const int first = std::max(0, at - kAny.reach);
  const int last = std::min(static_cast<int>(values.size()) - 1, at + kAny.reach);
  int low = at, high = at;
  bool torn = false;
  for (int i = last; i >= first; --i) {
    const auto here = static_cast<std::size_t>(i);
    if (std::isnan(values[here]))
      torn = true;
    else
      low = std::min(low, i), high = std::max(high, i);
    if (!sigmas.empty() && sigmas[here] > static_cast<float>(kAny.widest_whole)) torn = true;
  }
  const auto value = [&](int i) { return static_cast<double>(values[static_cast<std::size_t>(i)]); };
  return std::abs(value(high) - value(low)) > (torn ? kAny.steepest_torn : kAny.steepest) * (high - low);
}

bool is_veil_by_definition(const DisparityImage& image, int u, int v) {
  const auto along = [&](const std::vector<float>& of, int length, int first_u, int first_v, int du) {
    std::vector<float> line;
    for (int i = 0; i < length && !of.empty(); ++i)
      line.push_back(of[image.index(first_u + du * i, first_v + (1 - du) * i)]);
    return line;
  };
  return steep_by_definition(along(image.values, image.width, 0, v, 1),
                             along(image.sigma, image.width, 0, v, 1), u) ||
         steep_by_definition(along(image.values, image.height, u, 0, 0),
                             along(image.sigma, image.height, u, 0, 0), v);
}

RC_GTEST_PROP(Veil, IsWhatIsTooSteepOnEveryTarget, (std::uint64_t seed, bool with_sigma, bool with_weight)) {
  DisparityImage image = any_disparities(seed);
  if (with_sigma) estimate_sigma({}, image);
  RangeView whole;
  whole.camera.width = image.width, whole.camera.height = image.height;
  whole.depth = whole.sigma_depth = image.values;
  if (with_weight) whole.weight = image.values;
  test::on_every_target([&](const char* target) {
    RangeView view = whole;
    drop_veils(image, kAny, view);
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        const std::size_t i = image.index(u, v);
        if (std::isnan(image.values[i])) continue;
        const bool veil = is_veil_by_definition(image, u, v);
        if (std::isnan(view.depth[i]) != veil || std::isnan(view.sigma_depth[i]) != veil ||
            (with_weight && std::isnan(view.weight[i]) != veil))
          RC_FAIL(std::string(target));
        if (!veil) RC_ASSERT(view.depth[i] == image.values[i]);
      }
  });
}

}  // namespace
}  // namespace headway::vision
