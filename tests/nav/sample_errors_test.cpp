#include "nav/sample_errors.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "nav/inverse_depth.h"
#include "synthetic_room.h"
#include "tests/every_target.h"

namespace headway::nav {
namespace {

constexpr float kSigma = 0.004F;  // [1/m]
constexpr int kApart = 4;

struct Image {
  RingImage<float> w, sigma;
  Image(int width, int height) {
    w.reset(width, height);
    sigma.reset(width, height);
    for (int y = 0; y < height; ++y) std::fill_n(sigma.row(y), width, kSigma);
  }
  template <class Visit>
  void each(Visit visit) {
    for (int y = 0; y < w.height(); ++y) {
      for (int x = 0; x < w.width(); ++x) visit(x, y, w.row(y)[x]);
    }
  }
};

/// A slanted plane whose samples err by `share` of sigma.
Image plane(double share, int width = 157, int height = 120) {
  std::mt19937_64 random(4);
  Image image(width, height);
  image.each([&](int x, int y, float& w) {
    w = 0.4F + 0.001F * static_cast<float>(x) - 0.0007F * static_cast<float>(y) +
        kSigma * static_cast<float>(share * normal(random));
  });
  return image;
}

double errors_of(const Image& image) { return sample_errors(image.w, image.sigma, kApart); }

TEST(SampleErrors, AreWhatSamplesOfASlantedPlaneErrBy) {
  for (const double share : {0.0, 0.05, 0.1, 0.3, 0.6, 0.9})
    EXPECT_NEAR(errors_of(plane(share)), share, 0.005 + 0.08 * share);
}

TEST(SampleErrors, AreNeverMoreThanSigma) { EXPECT_EQ(errors_of(plane(2)), 1); }

TEST(SampleErrors, AreThoseOfSurfacesNotOfTheirEdgesAndCorners) {
  for (const double share : {0.1, 0.3}) {
    Image image = plane(share);
    // Four of nine second differences reach across an edge.
    image.each([](int x, int, float& w) { w += x % 36 < 18 ? 0.0F : 1.0F; });
    EXPECT_NEAR(errors_of(image), share, 0.01 + 0.1 * share);
    Image folded = plane(share);
    folded.each([](int x, int, float& w) {
      w +=
          0.5F * kSigma * static_cast<float>(std::abs(x % 36 - 18));  // the fold's second difference: 4 sigma
    });
    EXPECT_LE(errors_of(folded), 1.8 * share);
  }
}

TEST(SampleErrors, AreNotThoseThatNeighboursShareBeyondTheirReach) {
  Image image = plane(0);
  image.each([](int x, int, float& w) { w += kSigma * std::sin(static_cast<float>(x) / 40); });
  EXPECT_LT(errors_of(image), 0.01) << "a surface's own shape is no error";
}

/// Means of means, as views that are not made much smaller are read: noise of each sample's own, and noise
/// that blocks of `together` samples share, against what they err by in truth.
TEST(SampleErrors, AreWhatMeansErrBy) {
  for (const int together : {1, 2, 3}) {
    std::mt19937_64 random(9);
    Image noisy(240, 180);
    noisy.each([&](int x, int y, float& w) {
      const bool first = x % together == 0 && y % together == 0;
      if (first) w = 0.4F + kSigma * static_cast<float>(normal(random));
      if (!first) w = noisy.w.row(y - y % together)[x - x % together];
    });
    Image means(240, 180);
    RingImage<float> once;
    smooth(noisy.w, noisy.sigma, 1, 0, 1, once);
    smooth(once, noisy.sigma, 2, 0, 1, means.w);
    double sum = 0;
    int count = 0;
    for (int y = 4; y < 176; ++y) {
      for (int x = 4; x < 236; ++x, ++count) {
        const double error = (static_cast<double>(means.w.row(y)[x]) - 0.4) / static_cast<double>(kSigma);
        sum += error * error;
      }
    }
    const double truth = std::sqrt(sum / count);
    EXPECT_NEAR(sample_errors(means.w, means.sigma, 8), truth, 0.08 * truth) << together << " together";
  }
}

TEST(SampleErrors, AreNoneWhereTooLittleIsKnown) {
  EXPECT_EQ(errors_of(Image(157, 120)), 0) << "nothing is known";
  EXPECT_EQ(errors_of(plane(0.1, 2 * kApart, 120)), 0) << "no sample has two others so far away";
  Image exact = plane(0);
  for (int y = 0; y < exact.sigma.height(); ++y) std::fill_n(exact.sigma.row(y), exact.sigma.width(), 0.0F);
  EXPECT_EQ(errors_of(exact), 0) << "of no sigma there is no share";
}

TEST(SampleErrors, AreTheSameOnEveryInstructionSet) {
  Image image = plane(0.3, 101, 47);
  image.each([](int x, int y, float& w) { w = (x * 7 + y * 3) % 11 == 0 ? 0.0F : w; });
  hwy::GetChosenTarget().Update(HWY_SCALAR);
  const double plain = errors_of(image);
  EXPECT_NEAR(plain, 0.3, 0.06);
  headway::test::on_every_target(
      [&](const std::string& name) { EXPECT_EQ(errors_of(image), plain) << name; });
}

}  // namespace
}  // namespace headway::nav
