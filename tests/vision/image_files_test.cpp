#include "vision/image_files.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include "hal/error.h"
#include "vision/image_check.h"

namespace headway::vision {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

class ImageFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("headway_images_" + std::to_string(getpid()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  fs::path written(const Bytes& bytes, const std::string& name = "image.png") const {
    std::ofstream(folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return folder / name;
  }
  template <class Read>
  std::string message(Read read, const fs::path& file) const {
    try {
      read(file);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  fs::path folder;
};

Bytes encoded(const cv::Mat& image, const std::string& format = ".png") {
  Bytes bytes;
  cv::imencode(format, image, bytes);
  return bytes;
}

cv::Mat noise(int type) {
  cv::Mat image(20, 30, type);
  cv::RNG random(4);
  random.fill(image, cv::RNG::UNIFORM, 0, 255);
  return image;
}

const auto kGray = [](const fs::path& f) { read_gray(f); };
const auto kDisparity = [](const fs::path& f) { read_disparity(f); };
const auto kDepth = [](const fs::path& f) { read_depth(f); };

TEST_F(ImageFiles, GiveBackWhatWasWritten) {
  const cv::Mat image = noise(CV_8U);
  const hal::GrayImage found = read_gray(written(encoded(image)));
  ASSERT_EQ(found.width, 30);
  ASSERT_EQ(found.height, 20);
  EXPECT_TRUE(std::equal(found.pixels.begin(), found.pixels.end(), image.begin<std::uint8_t>()));
}

TEST_F(ImageFiles, TurnColourAndJpegToGray) {
  EXPECT_EQ(read_gray(written(encoded(noise(CV_8UC3)))).pixels.size(), 600U);
  EXPECT_EQ(read_gray(written(encoded(noise(CV_8UC3), ".jpg"), "image.jpg")).pixels.size(), 600U);
  EXPECT_EQ(read_gray(written(encoded(noise(CV_8UC3), ".ppm"))).pixels.size(), 600U)
      << "the name does not matter";
}

TEST_F(ImageFiles, ReadZeroAsUnknown) {
  cv::Mat image(1, 4, CV_16U);
  image.at<std::uint16_t>(0, 0) = 0, image.at<std::uint16_t>(0, 1) = 256 * 7 + 64;
  image.at<std::uint16_t>(0, 2) = 2500, image.at<std::uint16_t>(0, 3) = 65535;
  const fs::path file = written(encoded(image));
  const DisparityImage truth = read_disparity(file);
  EXPECT_TRUE(std::isnan(truth.values[0]));
  EXPECT_FLOAT_EQ(truth.values[1], 7.25F);
  const hal::DepthFrame depth = read_depth(file);
  EXPECT_TRUE(std::isnan(depth.depth[0]));
  EXPECT_FLOAT_EQ(depth.depth[2], 2.5F);
  EXPECT_TRUE(std::isnan(depth.depth[3]));
}

TEST_F(ImageFiles, SayWhatIsWrong) {
  EXPECT_THAT(message(kGray, folder / "none.png"), HasSubstr("none.png: no such image"));
  EXPECT_THAT(message(kGray, folder), HasSubstr("is not a file"));
  EXPECT_THAT(message(kGray, written({})), HasSubstr("is empty"));
  EXPECT_THAT(message(kGray, written({'h', 'e', 'l', 'l', 'o'})),
              HasSubstr("is not an image that can be read"));
  EXPECT_THAT(message(kDisparity, written(encoded(noise(CV_8U)))),
              HasSubstr("1 channel(s) of 8 bits, expected one of 16"));
  EXPECT_THAT(message(kDepth, written(encoded(noise(CV_16UC3)))), HasSubstr("3 channel(s) of 16 bits"));
}

TEST_F(ImageFiles, RefuseTruncatedFilesAtEveryLength) {
  for (const char* format : {".png", ".jpg", ".pgm"}) {
    const Bytes whole = encoded(noise(CV_8U), format);
    for (std::size_t length = 1; length < whole.size(); length += 7) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_NE(message(kGray, written(cut)), "") << format << " cut to " << length;
    }
  }
}

TEST_F(ImageFiles, RefuseSixteenBitFilesWithAnyFlippedByte) {
  const Bytes whole = encoded(noise(CV_16U));
  for (std::size_t at = 0; at < whole.size(); at += 3) {
    Bytes damaged = whole;
    damaged[at] ^= 0x55;
    EXPECT_NE(message(kDepth, written(damaged)), "") << "byte " << at;
  }
}

TEST_F(ImageFiles, RefuseHugeImagesBeforeDecodingThem) {
  EXPECT_THAT(message(kGray, written(encoded(cv::Mat(10001, 10001, CV_8U, cv::Scalar(0))))),
              HasSubstr("has 100.02 megapixels, expected at most 100"));
  const std::string pgm = "P5 # comment\n20000 20000 255\n";
  EXPECT_THAT(message(kGray, written(Bytes(pgm.begin(), pgm.end()))), HasSubstr("has 400 megapixels"));
}

TEST_F(ImageFiles, NeverCrashOnDamagedBytes) {
  cv::RNG random(11);
  for (const char* format : {".png", ".jpg", ".pgm", ".bmp"}) {
    const Bytes whole = encoded(noise(CV_8U), format);
    for (int round = 0; round < 60; ++round) {
      Bytes damaged = whole;
      for (int i = 1 + static_cast<int>(random(8U)); i > 0; --i)
        damaged[random(static_cast<unsigned>(std::min<std::size_t>(damaged.size(), i % 2 ? 40 : 1000000)))] =
            static_cast<std::uint8_t>(random(256U));
      if (round % 3 == 0) damaged.resize(1 + random(static_cast<unsigned>(damaged.size())));
      const std::string said = message(kGray, written(damaged));
      EXPECT_EQ(said.find('\n'), std::string::npos);
    }
  }
}

RC_GTEST_PROP(ImageCheck, SurvivesAnyBytes, (const Bytes& tail)) {
  for (const std::string start : {"", "\x89PNG\r\n\x1A\n", "\xFF\xD8\xFF", "P5\n3 2 255\n", "P6 9"}) {
    Bytes bytes(start.begin(), start.end());
    bytes.insert(bytes.end(), tail.begin(), tail.end());
    const std::string fault = image_fault(bytes, 100);
    RC_ASSERT(!fault.empty() || (start == "P5\n3 2 255\n" && tail.size() >= 6) || start == "P6 9" ||
              start[0] == '\xFF');
  }
}

}  // namespace
}  // namespace headway::vision
