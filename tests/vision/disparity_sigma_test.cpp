#include "vision/disparity_sigma.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/every_target.h"
#include "tests/vision/any_disparities.h"
#include "vision/doubt.h"

namespace headway::vision {
namespace {

constexpr SigmaModel kModel{.base = 0.25, .clear = 0.7, .doubtful = 2.6, .jump = 1};

/// Half the largest sum of the two opposite neighbours' steps, of those that lie in the image and on the
/// surface.
double bend_by_definition(const DisparityImage& image, int u, int v) {
  const auto step = [&](int du, int dv) {
    if (u + du < 0 || u + du >= image.width || v + dv < 0 || v + dv >= image.height) return std::nan("");
    const double there = static_cast<double>(image.values[image.index(u + du, v + dv)]);
    const double rise = there - static_cast<double>(image.values[image.index(u, v)]);
    return std::abs(rise) <= kModel.jump ? rise : std::nan("");
  };
  double most = 0;
  for (const auto& [du, dv] : {std::array{2, 0}, {2, 2}, {0, 2}, {-2, 2}})
    if (const double sum = step(du, dv) + step(-du, -dv); !std::isnan(sum))
      most = std::max(most, std::abs(sum));
  return most / 2;
}

double by_definition(const DisparityImage& image, int u, int v) {
  const std::size_t i = image.index(u, v);
  const double doubt = image.doubt.empty() ? std::nan("") : static_cast<double>(image.doubt[i]);
  const double base =
      image.doubt.empty() ? kModel.base : kModel.base * (kModel.clear + kModel.doubtful * doubt * doubt);
  return std::hypot(base, bend_by_definition(image, u, v));
}

RC_GTEST_PROP(DisparitySigma, IsThatOfDoubtAndBendOnEveryTarget, (std::uint64_t seed, bool with_doubt)) {
  DisparityImage image = any_disparities(seed);
  if (with_doubt) estimate_doubt({}, image);
  std::vector<float> first;
  test::on_every_target([&](const char* target) {
    estimate_sigma(kModel, image);
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        const std::size_t i = image.index(u, v);
        RC_ASSERT(std::isnan(image.sigma[i]) == std::isnan(image.values[i]));
        if (!std::isnan(image.values[i]) &&
            !(std::abs(static_cast<double>(image.sigma[i]) - by_definition(image, u, v)) <= 1e-6))
          RC_FAIL(std::string(target));
      }
    const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
    if (first.empty()) first = image.sigma;
    RC_ASSERT(std::ranges::equal(first, image.sigma, {}, bits, bits));
  });
}

TEST(DisparitySigma, IsTheRigsOwnOnAPlaneHoweverSlanted) {
  DisparityImage image;
  image.resize(30, 20);
  for (int v = 0; v < image.height; ++v)
    for (int u = 0; u < image.width; ++u)
      image.values[image.index(u, v)] = 10 + 0.25F * static_cast<float>(u) - 0.125F * static_cast<float>(v);
  estimate_sigma(kModel, image);
  for (const float sigma : image.sigma) EXPECT_FLOAT_EQ(sigma, 0.25F);
}

}  // namespace
}  // namespace headway::vision
