#include "vision/image_files.h"

#include <fstream>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "hal/error.h"
#include "vision/cv_image.h"
#include "vision/image_check.h"

namespace headway::vision {

namespace fs = std::filesystem;

namespace {

constexpr double kLargestMegapixels = 100;
constexpr std::uintmax_t kLargestFile = 512U << 20;

std::vector<std::uint8_t> read_bytes(const fs::path& file) {
  std::error_code ec;
  if (!fs::exists(file, ec))
    throw InputError(fmt::format("{}: no such image; check the path", file.string()));
  if (!fs::is_regular_file(file, ec))
    throw InputError(fmt::format("{}: is not a file, expected an image", file.string()));
  if (fs::file_size(file, ec) > kLargestFile)
    throw InputError(fmt::format("{}: larger than 512 MiB, expected an image", file.string()));
  std::ifstream in(file, std::ios::binary);
  std::vector<std::uint8_t> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in) throw InputError(fmt::format("{}: cannot be read; check its permissions", file.string()));
  return bytes;
}

cv::Mat decode(const fs::path& file, int mode) {
  const std::vector<std::uint8_t> bytes = read_bytes(file);
  if (const std::string fault = image_fault(bytes, kLargestMegapixels); !fault.empty())
    throw InputError(fmt::format("{}: {}", file.string(), fault));
  cv::Mat image;
  try {
    image = cv::imdecode(bytes, mode | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const std::exception&) {
    image.release();  // OpenCV throws on some damage and returns nothing on other; to the user it is the same
  }
  if (image.empty())
    throw InputError(
        fmt::format("{}: is damaged and cannot be decoded; export or copy the image again", file.string()));
  return image;
}

cv::Mat decode_16_bit(const fs::path& file) {
  const cv::Mat image = decode(file, cv::IMREAD_UNCHANGED);
  if (image.type() != CV_16UC1)
    throw InputError(fmt::format("{}: has {} channel(s) of {} bits, expected one of 16 bits", file.string(),
                                 image.channels(), 8 * image.elemSize1()));
  return image;
}

// Each value divided by `unit`; `missing` tells which values mean "nothing".
template <class Missing>
std::vector<float> scaled(const cv::Mat& image, double unit, Missing missing) {
  std::vector<float> values;
  values.reserve(image.total());
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const std::uint16_t raw = image.at<std::uint16_t>(v, u);
      values.push_back(missing(raw) ? DisparityImage::kNone : static_cast<float>(raw / unit));
    }
  return values;
}

}  // namespace

hal::GrayImage read_gray(const fs::path& file) {
  const cv::Mat image = decode(file, cv::IMREAD_GRAYSCALE);
  hal::GrayImage out;
  resize(out, image.cols, image.rows);
  cv::Mat target = as_mat(out);
  image.copyTo(target);
  return out;
}

DisparityImage read_disparity(const fs::path& file, double per_pixel) {
  const cv::Mat image = decode_16_bit(file);
  DisparityImage out;
  out.width = image.cols, out.height = image.rows;
  out.values = scaled(image, per_pixel, [](std::uint16_t raw) { return raw == 0; });
  return out;
}

hal::DepthFrame read_depth(const fs::path& file, double per_metre) {
  const cv::Mat image = decode_16_bit(file);
  hal::DepthFrame frame;
  frame.width = image.cols, frame.height = image.rows;
  frame.depth = scaled(image, per_metre, [](std::uint16_t raw) { return raw == 0 || raw == 65535; });
  return frame;
}

}  // namespace headway::vision
