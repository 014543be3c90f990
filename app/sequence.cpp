#include "app/sequence.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "app/pose_files.h"
#include "hal/error.h"
#include "hal/pose_history.h"
#include "vision/image_files.h"
#include "vision/rig_files.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kWidestGap = 500'000'000;  // [ns] between poses that are interpolated
constexpr std::int64_t kFarthestPose =
    5'000'000'000;                                    // [ns] from a frame to the nearest pose, standing still
constexpr Duration kDepthPeriod = seconds(1.0 / 30);  // depth images carry no stamps
constexpr std::size_t kMostFrames = 100'000;

void require_folder(const fs::path& folder, const std::string& what) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError(fmt::format("{}: no such folder, expected {}", folder.string(), what));
  }
}

/// Files of the folder whose names end so, by name.
std::vector<fs::path> files_in(const fs::path& folder, const std::string& ending) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename().string().ends_with(ending)) files.push_back(entry.path());
  }
  if (error) throw InputError(fmt::format("{}: cannot be listed ({})", folder.string(), error.message()));
  if (files.size() > kMostFrames) {
    throw InputError(
        fmt::format("{}: has {} images, expected at most {}", folder.string(), files.size(), kMostFrames));
  }
  std::sort(files.begin(), files.end());
  return files;
}

struct Pair {
  std::int64_t stamp_ns = 0;
  fs::path left, right;
};

std::vector<Pair> read_pairs(const fs::path& folder) {
  const fs::path left = folder / "cam0" / "data", right = folder / "cam1" / "data";
  require_folder(left, "the left camera's images");
  require_folder(right, "the right camera's images");
  const auto lefts = files_in(left, ".png"), rights = files_in(right, ".png");
  if (lefts.empty() && rights.empty()) {
    throw InputError(left.string() + ": holds no PNG images, expected stereo pairs named by their stamp");
  }
  if (lefts.size() != rights.size()) {
    throw InputError(fmt::format("{}: cam0 has {} images and cam1 {}, expected pairs of one name",
                                 folder.string(), lefts.size(), rights.size()));
  }
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < lefts.size(); ++i) {
    if (lefts[i].filename() != rights[i].filename()) {
      throw InputError(fmt::format("{}: has no partner in {} (there comes {}), expected pairs of one name",
                                   lefts[i].string(), right.string(), rights[i].filename().string()));
    }
    pairs.push_back({stamp_of_image(lefts[i]), lefts[i], rights[i]});
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.stamp_ns < b.stamp_ns; });
  return pairs;
}

fs::path find_pose_table(const fs::path& folder) {
  std::vector<fs::path> tables = files_in(folder, ".csv");
  std::erase_if(tables, [](const fs::path& p) { return !p.filename().string().starts_with("left_cam_gt"); });
  if (tables.size() != 1) {
    throw InputError(
        fmt::format("{}: holds {} files left_cam_gt*.csv, expected one with the left camera's poses",
                    folder.string(), tables.size()));
  }
  return tables.front();
}

constexpr double kClearlyUpright =
    0.5;  // mean height of the unit vector to the images' top: within 60 deg of up

/// Tables of left camera poses say q_RS, but those of EuRoC's V1_01 hold its inverse (their positions are
/// right: both compared with EuRoC's own body poses). A table is read inversely only where its images clearly
/// do not stand upright as written, and clearly do inversely: a camera that looks along -y stands upright
/// either way, and its table means what it says.
bool turn_upright(std::vector<StampedPose>& table) {
  double as_written = 0, inverse = 0;
  for (const StampedPose& p : table) {
    as_written -= p.pose.linear()(2, 1);  // how far the image's top points up
    inverse -= p.pose.linear()(1, 2);
  }
  const double clearly = kClearlyUpright * static_cast<double>(table.size());
  if (as_written >= clearly || inverse < clearly) return false;
  for (StampedPose& p : table) p.pose.linear() = p.pose.linear().transpose().eval();
  return true;
}

/// Looks poses up by stamp.
class Poses {
 public:
  Poses(std::vector<StampedPose> table, const SequenceOptions& options)
      : table_(std::move(table)), options_(options) {}

  struct Found {
    Eigen::Isometry3d pose;
    PoseSource source;
  };
  /// Nothing, and `why` says so, when the camera's pose is not known at that time.
  std::optional<Found> at(std::int64_t stamp, std::string& why) const {
    const auto later = std::lower_bound(table_.begin(), table_.end(), stamp,
                                        [](const StampedPose& p, std::int64_t t) { return p.stamp_ns < t; });
    if (later != table_.end() && later->stamp_ns == stamp) return Found{later->pose, PoseSource::kGiven};
    if (later == table_.begin()) return nearest(*later, stamp, why);
    if (later == table_.end()) return nearest(table_.back(), stamp, why);
    const StampedPose& earlier = *(later - 1);
    const std::int64_t gap = later->stamp_ns - earlier.stamp_ns;
    if (gap > kWidestGap) {
      why = fmt::format("lies in a gap of {:.2f} s between poses", static_cast<double>(gap) * 1e-9);
      return std::nullopt;
    }
    const double share = static_cast<double>(stamp - earlier.stamp_ns) / static_cast<double>(gap);
    return Found{hal::interpolate(earlier.pose, later->pose, share), PoseSource::kInterpolated};
  }

 private:
  std::optional<Found> nearest(const StampedPose& edge, std::int64_t stamp, std::string& why) const {
    const std::int64_t away = std::abs(edge.stamp_ns - stamp);
    const double away_s = static_cast<double>(away) * 1e-9;
    if (away > kFarthestPose) {
      why = fmt::format("is {:.2f} s from the nearest pose", away_s);
      return std::nullopt;
    }
    if (!stands_still(edge, away)) {
      why = fmt::format("is {:.2f} s from the nearest pose, and the camera moves there", away_s);
      return std::nullopt;
    }
    return Found{edge.pose, PoseSource::kNearest};
  }

  /// Over a stretch of poses as long as what they are to stand for.
  bool stands_still(const StampedPose& edge, std::int64_t stretch) const {
    std::int64_t covered = 0;
    for (const StampedPose& p : table_) {
      const std::int64_t away = std::abs(p.stamp_ns - edge.stamp_ns);
      if (away > stretch) continue;
      covered = std::max(covered, away);
      const Eigen::Isometry3d moved = edge.pose.inverse() * p.pose;
      if (moved.translation().norm() > options_.still_m) return false;
      if (Eigen::AngleAxisd(moved.linear()).angle() > options_.still_rad) return false;
    }
    return 2 * covered >= stretch;
  }

  std::vector<StampedPose> table_;
  SequenceOptions options_;
};

}  // namespace

const char* describe(PoseSource source) {
  switch (source) {
    case PoseSource::kGiven:
      return "given";
    case PoseSource::kInterpolated:
      return "interpolated";
    case PoseSource::kNearest:
      return "nearest pose (camera stands still)";
  }
  return "";
}

Sequence read_stereo_sequence(const fs::path& folder, const SequenceOptions& options) {
  Sequence sequence;
  sequence.layout = Sequence::Layout::kStereo;
  sequence.world_is_level = true;
  const std::vector<Pair> pairs = read_pairs(folder);
  sequence.rig = options.rig ? vision::read_rig(*options.rig) : vision::read_euroc_rig(folder);
  const fs::path table = find_pose_table(folder);
  std::vector<StampedPose> stamped = read_pose_table(table);
  sequence.rotations_inverted = turn_upright(stamped);
  const Poses poses(std::move(stamped), options);
  for (const Pair& pair : pairs) {
    std::string why;
    const std::string name = pair.left.stem().string();
    if (const auto found = poses.at(pair.stamp_ns, why)) {
      const Time stamp{Duration(pair.stamp_ns - pairs.front().stamp_ns)};
      sequence.frames.push_back({name, stamp, pair.left, pair.right, found->pose, found->source});
    } else {
      sequence.skipped.push_back(fmt::format("{}: {}", name, why));
    }
  }
  if (sequence.frames.empty()) {
    throw InputError(fmt::format("{}: no pair of {} has a pose, expected stamps that overlap", table.string(),
                                 folder.string()));
  }
  return sequence;
}

namespace {

/// Size and centre, by the first image.
void fit_camera(Sequence& sequence, const std::string& camera_from) {
  const hal::DepthFrame first = vision::read_depth(sequence.frames.front().left, sequence.depth_per_metre);
  sequence.camera.width = first.width;
  sequence.camera.height = first.height;
  if (!(sequence.camera.cx < first.width && sequence.camera.cy < first.height)) {
    throw InputError(fmt::format("{}: centre ({:g}, {:g}) lies outside the images of {} x {} px", camera_from,
                                 sequence.camera.cx, sequence.camera.cy, first.width, first.height));
  }
}

}  // namespace

Sequence read_depth_sequence(const fs::path& folder) {
  Sequence sequence;
  sequence.layout = Sequence::Layout::kDepth;
  sequence.camera = read_intrinsics(folder / "camera-intrinsics.txt");
  const auto images = files_in(folder, ".depth.png");
  if (images.empty()) {
    throw InputError(folder.string() + ": holds no depth images, expected frame-000000.depth.png and so on");
  }
  for (const fs::path& image : images) {
    const std::string file = image.filename().string();
    const std::string name = file.substr(0, file.size() - std::string(".depth.png").size());
    const Time stamp{kDepthPeriod * static_cast<Duration::rep>(sequence.frames.size())};
    const Eigen::Isometry3d pose = read_pose_matrix(folder / (name + ".pose.txt"));
    sequence.frames.push_back({name, stamp, image, {}, pose, PoseSource::kGiven});
  }
  fit_camera(sequence, (folder / "camera-intrinsics.txt").string());
  return sequence;
}

namespace {

constexpr double kTumDepth = 5000;  // units to the metre
constexpr std::int64_t kSecond = 1'000'000'000;

/// Whether frames are numbered in place of stamps, as ICL-NUIM's are.
bool numbered(const std::vector<StampedImage>& images) {
  constexpr std::int64_t kMost = kMostFrames * kSecond;
  return std::ranges::all_of(
      images, [](const StampedImage& i) { return i.stamp_ns % kSecond == 0 && i.stamp_ns <= kMost; });
}

/// ICL-NUIM's camera is (481.2, -480, 319.5, 239.5): its y axis, and the world's, are those of a mirror. What
/// is true there is true here with all y turned round.
void read_as_icl_nuim(Sequence& sequence, std::vector<StampedPose>& poses) {
  sequence.camera = {0, 0, (481.2 + 480) / 2, 319.5, 239.5};
  const Eigen::Matrix3d mirror = Eigen::Vector3d(1, -1, 1).asDiagonal();
  for (StampedPose& p : poses) {
    p.pose.linear() = (mirror * p.pose.linear() * mirror).eval();
    p.pose.translation() = (mirror * p.pose.translation()).eval();
  }
}

}  // namespace

Sequence read_tum_sequence(const fs::path& folder, const SequenceOptions& options) {
  Sequence sequence;
  sequence.layout = Sequence::Layout::kDepth;
  sequence.depth_per_metre = kTumDepth;
  std::error_code error;
  const fs::path pairs = folder / "associations.txt", table = folder / "groundtruth.txt",
                 intrinsics = folder / "camera-intrinsics.txt";
  const std::vector<StampedImage> images =
      read_tum_images(fs::exists(pairs, error) ? pairs : folder / "depth.txt");
  std::vector<StampedPose> stamped = read_tum_poses(table);
  if (fs::exists(intrinsics, error)) {
    sequence.camera = read_intrinsics(intrinsics);
  } else if (numbered(images)) {
    read_as_icl_nuim(sequence, stamped);
  } else {
    throw InputError(intrinsics.string() +
                     ": no such file, expected a 3x3 camera matrix: f 0 cx, 0 f cy, 0 0 1");
  }
  const Poses poses(std::move(stamped), options);
  for (const StampedImage& image : images) {
    std::string why;
    const std::string name = image.image.stem().string();
    if (const auto found = poses.at(image.stamp_ns, why)) {
      const Time stamp{Duration(image.stamp_ns - images.front().stamp_ns)};
      sequence.frames.push_back({name, stamp, image.image, {}, found->pose, found->source});
    } else {
      sequence.skipped.push_back(fmt::format("{}: {}", name, why));
    }
  }
  if (sequence.frames.empty()) {
    throw InputError(fmt::format("{}: no image of {} has a pose, expected stamps that overlap",
                                 table.string(), folder.string()));
  }
  fit_camera(sequence, intrinsics.string());
  return sequence;
}

Sequence read_sequence(const fs::path& folder, const SequenceOptions& options) {
  require_folder(folder, "a recorded sequence");
  std::error_code error;
  // EuRoC's archives keep everything below mav0.
  if (fs::is_directory(folder / "mav0", error)) return read_sequence(folder / "mav0", options);
  if (fs::is_directory(folder / "cam0", error)) return read_stereo_sequence(folder, options);
  if (fs::exists(folder / "groundtruth.txt", error)) return read_tum_sequence(folder, options);
  if (fs::exists(folder / "camera-intrinsics.txt", error) || !files_in(folder, ".depth.png").empty()) {
    return read_depth_sequence(folder);
  }
  throw InputError(
      folder.string() +
      ": holds no sequence, expected cam0/data and cam1/data (EuRoC) or frame-*.depth.png with "
      "frame-*.pose.txt and camera-intrinsics.txt, or groundtruth.txt with associations.txt or depth.txt "
      "(TUM, ICL-NUIM)");
}

}  // namespace headway::app
