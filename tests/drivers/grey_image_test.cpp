// Cameras' pixels to grey values; OpenCV is the oracle.
#include "drivers/grey_image.h"

#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <rapidcheck/gtest.h>

#include "drivers/depth_image.h"
#include "drivers/jpeg_decoder.h"

namespace headway::drivers {
namespace {

std::span<const std::uint8_t> bytes_of(const cv::Mat& image) {
  return {image.data, image.total() * image.elemSize()};
}

bool same(const hal::GrayImage& ours, const cv::Mat& theirs) {
  return ours.width == theirs.cols && ours.height == theirs.rows &&
         std::memcmp(ours.pixels.data(), theirs.data, ours.pixels.size()) == 0;
}

cv::Mat noise(int rows, int cols, int type, std::uint64_t seed) {
  cv::Mat image(rows, cols, type);
  cv::RNG random(seed);
  random.fill(image, cv::RNG::UNIFORM, 0, type == CV_16UC1 ? 65536 : 256);
  return image;
}

/// Something that JPEG keeps well.
cv::Mat scene(int width, int height) {
  cv::Mat image = noise(height, width, CV_8UC3, 7);
  cv::GaussianBlur(image, image, {0, 0}, 6);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  return image;
}

std::vector<std::uint8_t> jpeg_of(const cv::Mat& image, int quality = 90) {
  std::vector<std::uint8_t> data;
  cv::imencode(".jpg", image, data, {cv::IMWRITE_JPEG_QUALITY, quality});
  return data;
}

RC_GTEST_PROP(GreyImage, OfYuyvAndNv12IsWhatOpencvTakesForLuma, (std::uint64_t seed)) {
  const int width = 2 * *rc::gen::inRange(1, 40), height = 2 * *rc::gen::inRange(1, 40);
  hal::GrayImage ours;
  cv::Mat theirs;
  const cv::Mat yuyv = noise(height, width, CV_8UC2, seed);
  RC_ASSERT(copy_grey(bytes_of(yuyv), {PixelFormat::kYuyv, width, height, yuyv.step}, 16, ours));
  cv::cvtColor(yuyv, theirs, cv::COLOR_YUV2GRAY_YUYV);
  RC_ASSERT(same(ours, theirs));
  const cv::Mat nv12 = noise(height * 3 / 2, width, CV_8UC1, seed);
  RC_ASSERT(copy_grey(bytes_of(nv12), {PixelFormat::kNv12, width, height, nv12.step}, 16, ours));
  cv::cvtColor(nv12, theirs, cv::COLOR_YUV2GRAY_NV12);
  RC_ASSERT(same(ours, theirs));
}

RC_GTEST_PROP(GreyImage, OfY16KeepsTheHighestBits, (std::uint64_t seed)) {
  const int width = *rc::gen::inRange(1, 80), height = *rc::gen::inRange(1, 80);
  const int bits = *rc::gen::inRange(8, 17);
  const cv::Mat y16 = noise(height, width, CV_16UC1, seed);
  hal::GrayImage ours;
  RC_ASSERT(copy_grey(bytes_of(y16), {PixelFormat::kY16, width, height, y16.step}, bits, ours));
  cv::Mat theirs(y16.size(), CV_8UC1);
  for (int i = 0; i < static_cast<int>(y16.total()); ++i)
    theirs.at<std::uint8_t>(i / width, i % width) = cv::saturate_cast<std::uint8_t>(
        static_cast<int>(std::floor(std::ldexp(y16.at<std::uint16_t>(i / width, i % width), 8 - bits))));
  RC_ASSERT(same(ours, theirs));
}

RC_GTEST_PROP(GreyImage, LeavesOutThePaddingOfRows, (std::uint64_t seed)) {
  const int width = *rc::gen::inRange(1, 40), height = *rc::gen::inRange(1, 40);
  const int padding = *rc::gen::inRange(0, 30);
  const cv::Mat padded = noise(height, width + padding, CV_8UC1, seed);
  hal::GrayImage ours;
  RC_ASSERT(copy_grey(bytes_of(padded), {PixelFormat::kGrey, width, height, padded.step}, 16, ours));
  RC_ASSERT(same(ours, padded.colRange(0, width).clone()));
}

TEST(GreyImage, RefusesLessThanAWholeFrameAndOtherFormats) {
  for (const PixelFormat format : kPixelFormats) {
    const ImageLayout layout{format, 8, 6, 2 * row_bytes(format, 8)};
    const std::vector<std::uint8_t> whole(least_bytes(layout), 7);
    const bool is_grey = format != PixelFormat::kMjpeg && format != PixelFormat::kZ16;
    hal::GrayImage image;
    EXPECT_EQ(copy_grey(whole, layout, 16, image), is_grey) << int(format);
    hal::GrayImage untouched;
    EXPECT_FALSE(copy_grey(std::span(whole).first(whole.size() - 1), layout, 16, untouched));
    EXPECT_TRUE(untouched.pixels.empty());
    hal::DepthFrame depth;
    EXPECT_EQ(copy_depth(whole, layout, 0.001, depth), format == PixelFormat::kZ16);
    EXPECT_FALSE(copy_depth(std::span(whole).first(whole.size() - 1), layout, 0.001, depth));
  }
}

TEST(JpegDecoder, GivesTheGreyThatOpencvGives) {
  JpegDecoder decoder;
  for (const auto& [width, height] : {std::pair{64, 48}, {33, 17}, {640, 480}}) {
    const std::vector<std::uint8_t> data = jpeg_of(scene(width, height));
    hal::GrayImage ours;
    ASSERT_TRUE(decoder.decode(data, width, height, ours));
    const cv::Mat theirs = cv::imdecode(data, cv::IMREAD_GRAYSCALE);
    ASSERT_EQ(theirs.cols, width);
    cv::Mat difference;
    cv::absdiff(cv::Mat(height, width, CV_8UC1, ours.pixels.data()), theirs, difference);
    double most = 0;
    cv::minMaxLoc(difference, nullptr, &most);
    EXPECT_LE(most, 2);  // another inverse transform
  }
}

TEST(JpegDecoder, ComesNearToTheImageThatWasCompressed) {
  const cv::Mat image = scene(64, 48);
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  hal::GrayImage ours;
  ASSERT_TRUE(JpegDecoder().decode(jpeg_of(image, 98), 64, 48, ours));
  EXPECT_LT(cv::norm(cv::Mat(48, 64, CV_8UC1, ours.pixels.data()), grey, cv::NORM_L1) / (64 * 48), 1.5);
}

/// Takes the segments with this marker out.
std::vector<std::uint8_t> without_segments(const std::vector<std::uint8_t>& jpeg, std::uint8_t marker) {
  std::vector<std::uint8_t> kept(jpeg.begin(), jpeg.begin() + 2);
  std::size_t at = 2;
  while (jpeg[at + 1] != 0xDA) {
    const std::size_t end = at + 2 + (jpeg[at + 2] << 8 | jpeg[at + 3]);
    if (jpeg[at + 1] != marker)
      kept.insert(kept.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                  jpeg.begin() + static_cast<std::ptrdiff_t>(end));
    at = end;
  }
  kept.insert(kept.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at), jpeg.end());
  return kept;
}

TEST(JpegDecoder, ReadsFramesWithoutHuffmanTablesAsCamerasSendThem) {
  const std::vector<std::uint8_t> data = jpeg_of(scene(64, 48));
  const std::vector<std::uint8_t> bare = without_segments(data, 0xC4);
  ASSERT_LT(bare.size(), data.size());
  JpegDecoder decoder;
  hal::GrayImage whole, ours;
  ASSERT_TRUE(decoder.decode(data, 64, 48, whole));
  ASSERT_TRUE(decoder.decode(bare, 64, 48, ours));
  EXPECT_EQ(ours.pixels, whole.pixels);
}

TEST(JpegDecoder, RefusesWhatIsCutShortOrOfAnotherSize) {
  JpegDecoder decoder;
  const std::vector<std::uint8_t> data = jpeg_of(scene(64, 48));
  hal::GrayImage image;
  for (std::size_t size = 0; size + 2 < data.size(); size += 13)
    EXPECT_FALSE(decoder.decode(std::span(data).first(size), 64, 48, image)) << size;
  EXPECT_FALSE(decoder.decode(data, 48, 64, image));
  EXPECT_TRUE(decoder.decode(data, 64, 48, image));
}

RC_GTEST_PROP(JpegDecoder, SurvivesAnyBytes, (std::vector<std::uint8_t> spoilt)) {
  static JpegDecoder decoder;
  static const std::vector<std::uint8_t> good = jpeg_of(scene(64, 48));
  std::vector<std::uint8_t> data = good;
  const std::size_t at = *rc::gen::inRange<std::size_t>(0, data.size());
  std::copy_n(spoilt.begin(), std::min(spoilt.size(), data.size() - at),
              data.begin() + static_cast<std::ptrdiff_t>(at));
  hal::GrayImage image;
  if (decoder.decode(data, 64, 48, image)) RC_ASSERT(image.pixels.size() == 64u * 48u);
  RC_ASSERT(decoder.decode(good, 64, 48, image));
}

}  // namespace
}  // namespace headway::drivers
