#include "nav/sample_errors.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

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
  for (const double share : {0.1, 0.5}) {
    Image image = plane(share);
    // Four of nine second differences reach across an edge.
    image.each([](int x, int, float& w) { w += x % 36 < 18 ? 0.0F : 1.0F; });
    EXPECT_NEAR(errors_of(image), share, 0.01 + 0.1 * share);
    Image folded = plane(share);
    folded.each([](int x, int, float& w) {
      w += 0.5F * kSigma * static_cast<float>(std::abs(x % 36 - 18));  // four samples off: 4 sigma
    });
    EXPECT_LE(errors_of(folded), 2 * share);
  }
}

TEST(SampleErrors, AreNotThoseThatNeighboursShareBeyondTheirReach) {
  Image image = plane(0);
  image.each([](int x, int, float& w) { w += kSigma * std::sin(static_cast<float>(x) / 40); });
  EXPECT_LT(errors_of(image), 0.05) << "a surface's own shape is no error";
}

TEST(SampleErrors, AreTheUsualOnesWhereTooLittleIsKnown) {
  EXPECT_EQ(errors_of(Image(157, 120)), 0.5) << "nothing is known";
  EXPECT_EQ(errors_of(plane(0.1, 2 * kApart, 120)), 0.5) << "no sample has two others so far away";
  Image exact = plane(0);
  for (int y = 0; y < exact.sigma.height(); ++y) std::fill_n(exact.sigma.row(y), exact.sigma.width(), 0.0F);
  EXPECT_EQ(errors_of(exact), 0.5) << "of no sigma there is no share";
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
