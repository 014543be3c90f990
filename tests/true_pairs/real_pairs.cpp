#include <cstdlib>
#include <filesystem>
#include <optional>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/true_pairs/true_pairs.h"

namespace headway {

namespace {

namespace fs = std::filesystem;

struct Files {
  fs::path left, right, truth;
  double truth_unit;  // [px]
};

hal::GrayImage plain(const cv::Mat& image) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  return {whole.cols, whole.rows, {whole.data, whole.data + whole.total()}};
}

std::optional<TruePair> read(const std::string& name, int disparities, const Files& files,
                             std::optional<cv::Size> size) {
  cv::Mat left = cv::imread(files.left.string(), cv::IMREAD_GRAYSCALE),
          right = cv::imread(files.right.string(), cv::IMREAD_GRAYSCALE),
          units = cv::imread(files.truth.string(), cv::IMREAD_UNCHANGED), truth;
  if (left.empty() || right.empty() || units.empty()) return std::nullopt;
  units.convertTo(truth, CV_32F, files.truth_unit);
  if (size) {
    truth *= static_cast<double>(size->width) / left.cols;
    cv::resize(left, left, *size, 0, 0, cv::INTER_AREA);
    cv::resize(right, right, *size, 0, 0, cv::INTER_AREA);
    cv::resize(truth, truth, *size, 0, 0, cv::INTER_NEAREST);
  }
  TruePair pair{name, disparities, plain(left), plain(right), half_a_row_lower(plain(right)), {}};
  pair.truth.resize(truth.cols, truth.rows);
  for (int v = 0; v < truth.rows; ++v)
    for (int u = 0; u < truth.cols; ++u)
      if (const float d = truth.at<float>(v, u); d > 0) pair.truth.values[pair.truth.index(u, v)] = d;
  leave_out_first_columns(pair);
  return pair;
}

Files of_data(const std::string& name) {
  const char* data = std::getenv("HEADWAY_DATA");
  const fs::path folder = fs::path(data ? data : "") / "stereo" / name;
  return {folder / "left.png", folder / "right.png", folder / "gt16.png", 1.0 / 256};
}

}  // namespace

hal::GrayImage half_a_row_lower(const hal::GrayImage& image) {
  hal::GrayImage out = image;
  const auto width = static_cast<std::size_t>(image.width);
  for (std::size_t i = width; i < out.pixels.size(); ++i)
    out.pixels[i] = static_cast<std::uint8_t>((image.pixels[i] + image.pixels[i - width] + 1) / 2);
  return out;
}

std::vector<TruePair> real_pairs() {
  const fs::path doc = "/usr/share/doc/opencv-doc/examples/data";
  const Files aloe{doc / "aloeL.jpg", doc / "aloeR.jpg", doc / "aloeGT.png", 1};
  std::vector<TruePair> all;
  if (auto p = read("motorcycle", 64, of_data("motorcycle"), cv::Size(640, 480)))
    all.push_back(*std::move(p));
  if (auto p = read("aloe", 128, aloe, cv::Size(641, 555))) all.push_back(*std::move(p));
  if (auto p = read("tsukuba", 64, of_data("tsukuba"), std::nullopt)) all.push_back(*std::move(p));
  return all;
}

std::vector<TruePair> held_out_pairs() {
  std::vector<TruePair> all = room_pairs();
  for (const auto& more : {photo_pairs(), synthesised_pairs()})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace headway
