#include "app/drawing.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

/// Luma as the eye weighs it.
double brightness(const Colour& c) { return 0.114 * c[0] + 0.587 * c[1] + 0.299 * c[2]; }

TEST(Ramp, GetsBrighterAllTheWay) {
  for (const Ramp ramp : {Ramp::kViridis, Ramp::kInferno}) {
    for (int i = 1; i <= 16; ++i) {
      EXPECT_GT(brightness(ramp_colour(ramp, i / 16.0)), brightness(ramp_colour(ramp, (i - 1) / 16.0))) << i;
    }
  }
}

TEST(Ramp, ClampsWhatLiesBeyondItsEnds) {
  EXPECT_EQ(ramp_colour(Ramp::kViridis, -3), ramp_colour(Ramp::kViridis, 0));
  EXPECT_EQ(ramp_colour(Ramp::kViridis, 3), ramp_colour(Ramp::kViridis, 1));
}

TEST(Mixing, EndsAtItsTwoColours) {
  const Colour a{10, 200, 0}, b{250, 0, 90};
  EXPECT_EQ(mixed(a, b, 0), a);
  EXPECT_EQ(mixed(a, b, 1), b);
}

RC_GTEST_PROP(Ticks, AreRoundAndAboutAsManyAsWanted, ()) {
  const int wanted = *rc::gen::inRange(3, 12);
  const double range = std::pow(10.0, *rc::gen::inRange(-400, 400) / 100.0);
  const double step = tick_step(range, wanted);
  const double lead = step / std::pow(10.0, std::floor(std::log10(step) + 1e-9));
  RC_ASSERT(std::abs(lead - 1) < 1e-6 || std::abs(lead - 2) < 1e-6 || std::abs(lead - 5) < 1e-6);
  RC_ASSERT(range / step > wanted / 2.1);
  RC_ASSERT(range / step < wanted * 2.1);
}

TEST(Ticks, StandWhereTheirValuesLie) {
  const auto ticks = linear_ticks(1.3, 4.8, 6);
  ASSERT_GE(ticks.size(), 3U);
  for (const Tick& t : ticks) EXPECT_NEAR(1.3 + t.share * 3.5, std::stod(t.label), 1e-6);
}

TEST(Ticks, NameShortLengthsInMillimetres) {
  std::vector<std::string> labels;
  for (const Tick& t : logarithmic_length_ticks(0.001, 1)) labels.push_back(t.label);
  EXPECT_EQ(labels, (std::vector<std::string>{"1 mm", "2 mm", "5 mm", "10 mm", "20 mm", "50 mm", "100 mm",
                                              "200 mm", "500 mm", "1 m"}));
}

TEST(Ticks, AreNoneOnAnEmptyOrImpossibleRange) {
  EXPECT_TRUE(linear_ticks(2, 2).empty());
  EXPECT_TRUE(linear_ticks(3, 2).empty());
  EXPECT_TRUE(logarithmic_length_ticks(0, 1).empty());
}

TEST(Legend, KeepsTheImageAndShowsTheRampBesideIt) {
  const Colour green{1, 200, 3};
  const cv::Mat image = canvas(60, 80, green);
  const cv::Mat out = with_legend(image, "t", Ramp::kViridis, {{0, "0"}, {1, "1"}});
  ASSERT_GT(out.cols, 60);
  ASSERT_GT(out.rows, 80);
  const int top = out.rows - 80;
  EXPECT_EQ(out.at<Colour>(top, 0), green);
  EXPECT_EQ(out.at<Colour>(out.rows - 1, 59), green);
  const auto shows = [&](const Colour& wanted) {
    for (int y = 0; y < out.rows; ++y) {
      for (int x = 60; x < out.cols; ++x) {
        if (out.at<Colour>(y, x) == wanted) return y;
      }
    }
    return -1;
  };
  EXPECT_GE(shows(ramp_colour(Ramp::kViridis, 0)), 0);
  EXPECT_GE(shows(ramp_colour(Ramp::kViridis, 1)), 0);
  EXPECT_LT(shows(ramp_colour(Ramp::kViridis, 1)), shows(ramp_colour(Ramp::kViridis, 0)));  // high is up
}

TEST(Legend, HasRoomForAllOfItsTitle) {
  const std::string title = "uncertainty of each point: largest standard deviation";
  const cv::Mat narrow = with_legend(canvas(170, 240, {1, 200, 3}), title, Ramp::kInferno, {});
  const int top = narrow.rows - 240;
  EXPECT_GE(top, 2 * 20) << "two lines on 266 px";
  for (const int x : {0, 1, narrow.cols - 2, narrow.cols - 1})
    for (int y = 0; y < top; ++y) EXPECT_EQ(narrow.at<Colour>(y, x), colours::kBackground) << "cut off";
}

TEST(Wrapped, KeepsEveryWordAndFitsTheWidth) {
  const std::string text = "largest standard deviation of each of the points";
  for (const int width : {120, 200, 1000}) {
    std::string all;
    for (const std::string& line : wrapped(text, width)) {
      EXPECT_LE(text_width(line), width);
      all += (all.empty() ? "" : " ") + line;
    }
    EXPECT_EQ(all, text);
  }
  EXPECT_EQ(wrapped(text, 1000).size(), 1U);
  EXPECT_EQ(wrapped(text, 1).size(), 8U) << "a word each";
  EXPECT_TRUE(wrapped("", 100).empty());
}

TEST(Plate, MakesInkReadableOnAnything) {
  cv::Mat image = canvas(60, 40, {90, 20, 40});
  draw_plate(image, {10, 10, 100, 20});
  EXPECT_EQ(image.at<Colour>(5, 5), (Colour{90, 20, 40}));
  EXPECT_GT(image.at<Colour>(20, 30)[1], 200);
}

TEST(Strip, HoldsAllPicturesAtOneHeight) {
  const Colour red{0, 0, 255}, blue{255, 0, 0};
  const cv::Mat out = strip({{canvas(100, 50, red), "one"}, {canvas(80, 100, blue), "two"}});
  EXPECT_EQ(out.at<Colour>(25, 50), red);
  EXPECT_EQ(out.at<Colour>(25, out.cols - 20), blue);
  EXPECT_NEAR(out.cols, 100 + 40, 12);  // the second is halved
}

TEST(Strip, OfNothingIsAnImageAllTheSame) { EXPECT_FALSE(strip({}).empty()); }

TEST(PngFile, ComesBackAsItWas) {
  const TemporaryFolder folder;
  cv::Mat image = canvas(20, 10, {1, 2, 3});
  image.at<Colour>(4, 7) = {200, 100, 50};
  write_png(image, folder / "a.png");
  const cv::Mat back = cv::imread((folder / "a.png").string());
  ASSERT_EQ(back.size(), image.size());
  EXPECT_EQ(back.at<Colour>(4, 7), (Colour{200, 100, 50}));
  EXPECT_EQ(back.at<Colour>(0, 0), (Colour{1, 2, 3}));
}

TEST(PngFile, OfAFolderThatIsNotThereIsAnInputError) {
  const TemporaryFolder folder;
  try {
    write_png(canvas(2, 2, {}), folder / "none" / "a.png");
    FAIL() << "nothing was thrown";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("a.png"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace headway::app
