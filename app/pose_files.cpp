#include "app/pose_files.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "hal/angle.h"
#include "hal/error.h"

namespace headway::app {

namespace {

constexpr std::uintmax_t kLargestFile = 64U << 20;  // an hour of poses at 200 Hz
constexpr double kFarthest = 1e5;                   // [m] from the origin; beyond it is no pose

struct TextLine {
  int number;
  std::string text;
};

/// The lines of a file that are neither empty nor comments.
std::vector<TextLine> read_lines(const std::filesystem::path& file, const char* what) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(fmt::format("{}: no such file, expected {}", file.string(), what));
  }
  if (std::filesystem::file_size(file, error) > kLargestFile) {
    throw InputError(fmt::format("{}: larger than 64 MiB, expected {}", file.string(), what));
  }
  std::ifstream in(file);
  std::vector<TextLine> lines;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first != std::string::npos && text[first] != '#') lines.push_back({number, text});
  }
  if (!in.eof()) throw InputError(fmt::format("{}: cannot be read; check its permissions", file.string()));
  return lines;
}

[[noreturn]] void fail(const std::filesystem::path& file, int line, const std::string& what) {
  throw InputError(fmt::format("{}:{}: {}", file.string(), line, what));
}

std::vector<std::string_view> split(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = text.find_first_not_of(separators, at);
    if (begin == std::string_view::npos) break;
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    at = end;
  }
  return parts;
}

/// A whole word that is a finite number.
double number_of(const std::filesystem::path& file, int line, std::string_view word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
    fail(file, line, fmt::format("'{}', expected a number", word.substr(0, 40)));
  }
  return value;
}

/// Nanoseconds; some tables append ".0000".
std::int64_t stamp_of(const std::filesystem::path& file, int line, std::string_view word) {
  const std::string_view whole = word.substr(0, word.find('.'));
  std::int64_t ns = 0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), ns);
  if (error != std::errc() || end != whole.data() + whole.size() || ns < 0) {
    fail(file, line, fmt::format("'{}', expected a stamp in whole nanoseconds", word.substr(0, 40)));
  }
  return ns;
}

/// Seconds with a fraction, to nanoseconds.
std::int64_t stamp_in_seconds(const std::filesystem::path& file, int line, std::string_view word) {
  const double stamp = number_of(file, line, word);
  if (!(stamp >= 0 && stamp < 9e9)) fail(file, line, fmt::format("'{}', expected a stamp in seconds", word));
  return std::llround(stamp * 1e9);
}

/// How a table of poses is written.
struct PoseColumns {
  const char* names;
  std::int64_t (*stamp)(const std::filesystem::path& file, int line, std::string_view word);
  std::size_t w;  ///< column of the quaternion's real part
  std::size_t x;  ///< of its first imaginary one; the others follow
};
constexpr PoseColumns kEuroc{"stamp [ns], x, y, z [m], qw, qx, qy, qz", stamp_of, 4, 5};
constexpr PoseColumns kTum{"stamp [s], x, y, z [m], qx, qy, qz, qw", stamp_in_seconds, 7, 4};

StampedPose pose_of(const std::filesystem::path& file, const TextLine& line, const PoseColumns& columns) {
  constexpr std::size_t kColumns = 8;
  const auto words = split(line.text, ", \t\r");
  if (words.size() < kColumns)
    fail(file, line.number, fmt::format("has {} values, expected 8: {}", words.size(), columns.names));
  std::array<double, kColumns> v{};
  for (std::size_t i = 1; i < kColumns; ++i) v[i] = number_of(file, line.number, words[i]);
  const Eigen::Quaterniond q(v[columns.w], v[columns.x], v[columns.x + 1], v[columns.x + 2]);
  if (!(std::abs(q.norm() - 1) < 0.01))
    fail(file, line.number,
         fmt::format("the quaternion has length {:.3g}, expected 1 ({})", q.norm(), columns.names));
  StampedPose pose{columns.stamp(file, line.number, words[0]), Eigen::Isometry3d::Identity()};
  pose.pose.linear() = q.normalized().toRotationMatrix();
  pose.pose.translation() << v[1], v[2], v[3];
  if (!(pose.pose.translation().norm() < kFarthest))
    fail(file, line.number, "lies beyond 100 km, expected metres");
  return pose;
}

/// `rows` lines of `columns` numbers, row by row.
std::vector<double> read_matrix(const std::filesystem::path& file, std::size_t rows, std::size_t columns,
                                const char* what) {
  const std::vector<TextLine> lines = read_lines(file, what);
  if (lines.size() != rows) {
    throw InputError(
        fmt::format("{}: has {} rows, expected {} ({})", file.string(), lines.size(), rows, what));
  }
  std::vector<double> values;
  for (const TextLine& line : lines) {
    const auto words = split(line.text, ", \t\r");
    if (words.size() != columns) {
      fail(file, line.number, fmt::format("has {} values, expected {} ({})", words.size(), columns, what));
    }
    for (const std::string_view word : words) values.push_back(number_of(file, line.number, word));
  }
  return values;
}

}  // namespace

namespace {

std::vector<StampedPose> read_poses(const std::filesystem::path& file, const PoseColumns& columns) {
  std::vector<StampedPose> poses;
  int line_before = 0;
  for (const TextLine& line : read_lines(file, fmt::format("poses: {}", columns.names).c_str())) {
    const StampedPose pose = pose_of(file, line, columns);
    if (!poses.empty() && pose.stamp_ns <= poses.back().stamp_ns) {
      fail(file, line.number,
           fmt::format("its stamp is not later than that of line {}, expected rising stamps", line_before));
    }
    line_before = line.number;
    poses.push_back(pose);
  }
  if (poses.empty()) throw InputError(file.string() + ": holds no poses, expected at least one");
  return poses;
}

}  // namespace

std::vector<StampedPose> read_pose_table(const std::filesystem::path& csv) { return read_poses(csv, kEuroc); }
std::vector<StampedPose> read_tum_poses(const std::filesystem::path& file) { return read_poses(file, kTum); }

std::vector<StampedImage> read_tum_images(const std::filesystem::path& file) {
  constexpr const char* kWhat = "a list of images: stamp [s] depth/NAME.png, with or without those of colour";
  std::vector<StampedImage> images;
  for (const TextLine& line : read_lines(file, kWhat)) {
    const auto words = split(line.text, ", \t\r");
    const std::size_t depth = words.size() == 4 && !words[1].starts_with("depth") ? 2 : 0;
    if (words.size() != 2 && words.size() != 4)
      fail(file, line.number, fmt::format("has {} words, expected {}", words.size(), kWhat));
    images.push_back(
        {stamp_in_seconds(file, line.number, words[depth]), file.parent_path() / words[depth + 1]});
    if (images.size() > 1 && images.back().stamp_ns <= images[images.size() - 2].stamp_ns)
      fail(file, line.number, "its stamp is not later than the one before, expected rising stamps");
  }
  if (images.empty()) throw InputError(fmt::format("{}: names no images, expected {}", file.string(), kWhat));
  return images;
}

std::vector<vision::HeadSample> read_head_table(const std::filesystem::path& csv) {
  std::vector<vision::HeadSample> samples;
  for (const TextLine& line : read_lines(csv, "head samples: stamp [ns], pan [deg], tilt [deg]")) {
    const auto words = split(line.text, ", \t\r");
    if (words.size() != 3) {
      fail(csv, line.number,
           fmt::format("has {} values, expected 3: stamp [ns], pan [deg], tilt [deg]", words.size()));
    }
    const Time stamp{Duration(stamp_of(csv, line.number, words[0]))};
    const double pan = number_of(csv, line.number, words[1]), tilt = number_of(csv, line.number, words[2]);
    if (!(std::abs(pan) <= 180 && std::abs(tilt) <= 180))
      fail(csv, line.number, fmt::format("{} and {} deg, expected angles of -180 to 180 deg", pan, tilt));
    if (!samples.empty() && stamp <= samples.back().stamp)
      fail(csv, line.number, "its stamp is not later than the one before, expected rising stamps");
    samples.push_back({stamp, {pan * kDegree, tilt * kDegree}});
  }
  if (samples.empty())
    throw InputError(csv.string() + ": holds no head samples, expected them at 20 Hz or more");
  return samples;
}

std::int64_t stamp_of_image(const std::filesystem::path& image) {
  const std::string stem = image.stem().string();
  std::int64_t ns = 0;
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), ns);
  if (error != std::errc() || end != stem.data() + stem.size() || ns < 0) {
    throw InputError(image.string() +
                     ": is not named by its stamp, expected nanoseconds, as 1403715273262142976.png");
  }
  return ns;
}

Eigen::Isometry3d read_pose_matrix(const std::filesystem::path& file) {
  const auto values = read_matrix(file, 4, 4, "a 4x4 pose, world from camera");
  const Eigen::Matrix4d m = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  if (!((m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() < 1e-6)) {
    throw InputError(file.string() + ": its last row is not 0 0 0 1, expected a 4x4 pose, world from camera");
  }
  const Eigen::Matrix3d r = m.topLeftCorner<3, 3>();
  if (!((r * r.transpose() - Eigen::Matrix3d::Identity()).norm() < 0.02) || r.determinant() < 0) {
    throw InputError(file.string() + ": its upper left 3x3 is not a rotation, expected a rigid 4x4 pose");
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(r).normalized().toRotationMatrix();
  pose.translation() = m.topRightCorner<3, 1>();
  if (!(pose.translation().norm() < kFarthest)) {
    throw InputError(file.string() + ": lies beyond 100 km, expected metres");
  }
  return pose;
}

vision::PinholeCamera read_intrinsics(const std::filesystem::path& file) {
  const auto k = read_matrix(file, 3, 3, "a 3x3 camera matrix: f 0 cx, 0 f cy, 0 0 1");
  const auto bad = [&](const std::string& what) {
    throw InputError(
        fmt::format("{}: {}, expected a 3x3 camera matrix: f 0 cx, 0 f cy, 0 0 1 [px]", file.string(), what));
  };
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    bad("it is no camera matrix without skew");
  if (!(k[0] > 1 && k[0] < 1e6)) bad(fmt::format("focal length {:g} px", k[0]));
  if (!(std::abs(k[0] - k[4]) < 0.005 * k[0]))
    bad(fmt::format("focal lengths {:g} and {:g} differ", k[0], k[4]));
  if (!(k[2] > 0 && k[2] < 1e5 && k[5] > 0 && k[5] < 1e5))
    bad(fmt::format("centre ({:g}, {:g})", k[2], k[5]));
  return {0, 0, (k[0] + k[4]) / 2, k[2], k[5]};
}

}  // namespace headway::app
