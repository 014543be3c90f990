// A floor, a slanted wall and boards, all covered with photographs: natural textures on surfaces that are
// known exactly.
#include <Eigen/LU>
#include <array>
#include <filesystem>
#include <random>

#include <opencv2/imgcodecs.hpp>

#include "tests/true_pairs/true_pairs.h"

namespace headway {

namespace {

using Eigen::Vector3d;

constexpr int kWidth = 640, kHeight = 480;
constexpr double kFocal = 540, kBaseline = 0.144;  // [px], [m]

/// A parallelogram [m] in the left camera's optical frame with a photograph on it.
struct Board {
  Vector3d corner, across, down;
  cv::Mat1b photo;

  /// Where a ray meets it: (share across, share down, distance along the ray); the last is 0 beside it.
  Vector3d met(const Vector3d& from, const Vector3d& along) const {
    Eigen::Matrix3d sides;
    sides << across, down, -along;
    const Vector3d at = sides.inverse() * (from - corner);
    return at.x() >= 0 && at.x() < 1 && at.y() >= 0 && at.y() < 1 && at.z() > 0 ? at : Vector3d::Zero();
  }
  double grey(const Vector3d& at) const {
    const double x = at.x() * (photo.cols - 2), y = at.y() * (photo.rows - 2);
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const double a = x - i, b = y - j;
    return (1 - b) * ((1 - a) * photo(j, i) + a * photo(j, i + 1)) +
           b * ((1 - a) * photo(j + 1, i) + a * photo(j + 1, i + 1));
  }
};

struct Seen {
  double depth = 0, grey = 0;
};

Seen look(const std::vector<Board>& boards, const Vector3d& from, double u, double v) {
  const Vector3d along((u - 319.5) / kFocal, (v - 239.5) / kFocal, 1);
  Seen nearest{1e9, 0};
  for (const Board& board : boards)
    if (const Vector3d at = board.met(from, along); at.z() > 0 && at.z() < nearest.depth)
      nearest = {at.z(), board.grey(at)};
  return nearest;
}

/// Each pixel is the mean of four by four rays, with the noise of a sensor.
hal::GrayImage taken(const std::vector<Board>& boards, const Vector3d& from, double lower, unsigned seed) {
  constexpr int kRays = 4;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 2);
  hal::GrayImage image{kWidth, kHeight, {}};
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      double sum = 0;
      for (int i = 0; i < kRays * kRays; ++i)
        sum += look(boards, from, u + (i % kRays + 0.5) / kRays - 0.5,
                    v - lower + (i / kRays + 0.5) / kRays - 0.5)
                   .grey;
      image.pixels.push_back(cv::saturate_cast<std::uint8_t>(sum / (kRays * kRays) + noise(random)));
    }
  return image;
}

}  // namespace

std::vector<TruePair> photo_pairs() {
  const std::filesystem::path folder = "/usr/share/doc/opencv-doc/examples/data";
  const std::array<const char*, 6> names{"building.jpg", "fruits.jpg",       "home.jpg",
                                         "baboon.jpg",   "rubberwhale1.png", "graf1.png"};
  std::vector<cv::Mat1b> photos;
  for (const char* name : names) {
    photos.emplace_back(cv::imread((folder / name).string(), cv::IMREAD_GRAYSCALE));
    if (photos.back().empty()) return {};
  }
  const std::vector<Board> boards{{{-6, -5, 5.5}, {12, 0, -1.5}, {0, 7, 0}, photos[0]},
                                  {{-4, 1, 5.5}, {8, 0, 0}, {0, 0.3, -5}, photos[1]},
                                  {{-1.3, -0.7, 2.6}, {0.9, 0.1, 0.5}, {0, 0.9, -0.1}, photos[2]},
                                  {{0.15, -0.3, 1.9}, {0.5, 0, -0.2}, {0.1, 0.55, 0}, photos[3]},
                                  {{0.75, -0.9, 3}, {0.9, -0.1, -0.7}, {0, 1.2, 0.2}, photos[4]},
                                  {{-0.6, 0.1, 1.5}, {0.45, 0, 0.3}, {0, 0.35, 0.15}, photos[5]}};
  const Vector3d left = Vector3d::Zero(), right(kBaseline, 0, 0);
  TruePair pair{
      "photos", 0, taken(boards, left, 0, 1), taken(boards, right, 0, 2), taken(boards, right, 0.5, 3), {}};
  pair.truth.resize(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      if (const double z = look(boards, left, u, v).depth; z < 1e9)
        pair.truth.values[pair.truth.index(u, v)] = static_cast<float>(kFocal * kBaseline / z);
  search_all(pair);
  leave_out_first_columns(pair);
  return {pair};
}

}  // namespace headway
