#include "app/sequence.h"

#include <cstdlib>
#include <fstream>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "app/drawing.h"
#include "app/pose_files.h"
#include "hal/error.h"
#include "hal/head_kinematics.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// The message of the InputError that `act` throws.
template <class Act>
std::string error_of(const Act& act) {
  try {
    act();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

std::string row(std::int64_t ns, const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d t = pose.translation();
  return fmt::format("{}.0000,{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}\n", ns, t.x(), t.y(), t.z(),
                     q.w(), q.x(), q.y(), q.z());
}

/// An upright camera that looks along x, somewhat down.
Eigen::Isometry3d upright(double x, double down = 0.2) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = hal::body_from_optical(down);
  pose.translation() << x, 1, 1.5;
  return pose;
}

constexpr const char* kSensor =
    "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, {}, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
    "resolution: [64, 48]\ncamera_model: pinhole\nintrinsics: [50, 50, 31.5, 23.5]\n"
    "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n";

/// Four pairs at 4 Hz from 1 s on; the table says where the camera is.
class StereoFolder {
 public:
  explicit StereoFolder(const std::string& table) {
    for (const char* cam : {"cam0", "cam1"}) {
      for (int i = 0; i < 4; ++i) {
        fs::create_directories(folder_ / cam / "data");
        write_png(canvas(64, 48, {90, 90, 90}),
                  folder_ / cam / "data" / fmt::format("{}.png", 1000000000 + i * 250000000));
      }
    }
    write_text(folder_ / "cam0" / "sensor.yaml", fmt::format(fmt::runtime(kSensor), 0.0));
    write_text(folder_ / "cam1" / "sensor.yaml", fmt::format(fmt::runtime(kSensor), 0.1));
    write_text(folder_ / "left_cam_gt_X.csv", "#stamp,x,y,z,w,x,y,z\n" + table);
  }
  const fs::path& path() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
};

std::string standing_table(double first_s, double last_s) {
  std::string table;
  for (double t = first_s; t <= last_s + 1e-9; t += 0.05) table += row(std::llround(t * 1e9), upright(2));
  return table;
}

TEST(StereoSequence, PairsImagesOfOneNameAndKnowsTheirRig) {
  const StereoFolder folder(standing_table(1, 2));
  const Sequence sequence = read_sequence(folder.path());
  EXPECT_EQ(sequence.layout, Sequence::Layout::kStereo);
  ASSERT_EQ(sequence.frames.size(), 4U);
  EXPECT_EQ(sequence.frames[1].left.filename(), sequence.frames[1].right.filename());
  EXPECT_EQ(sequence.frames[1].stamp, at_seconds(0.25));
  ASSERT_TRUE(sequence.rig);
  EXPECT_NEAR(sequence.rig->baseline(), 0.1, 1e-12);
  EXPECT_TRUE(sequence.world_is_level);
}

TEST(StereoSequence, InterpolatesPosesAtTheStampsOfTheImages) {
  std::string table;
  for (int i = 0; i <= 14; ++i)
    table += row(900'000'000LL + i * 100'000'000LL, upright(0.9 + 0.1 * i));  // 1 m/s along x
  const StereoFolder folder(table);
  const Sequence sequence = read_sequence(folder.path());
  ASSERT_EQ(sequence.frames.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(sequence.frames[static_cast<std::size_t>(i)].world_from_camera.translation().x(),
                1 + 0.25 * i, 1e-6);
  }
  EXPECT_EQ(sequence.frames[1].pose_source, PoseSource::kInterpolated);
}

TEST(StereoSequence, TakesTheNearestPoseOnlyWhereTheCameraStandsStill) {
  const StereoFolder still(standing_table(1.6, 3));
  const Sequence standing = read_sequence(still.path());
  ASSERT_EQ(standing.frames.size(), 4U);
  EXPECT_EQ(standing.frames[0].pose_source, PoseSource::kNearest);
  std::string moving;
  for (int i = 0; i <= 14; ++i) moving += row(1'600'000'000LL + i * 100'000'000LL, upright(0.1 * i));
  const StereoFolder folder(moving);
  const Sequence sequence = read_sequence(folder.path());
  EXPECT_EQ(sequence.frames.size(), 1U);
  ASSERT_EQ(sequence.skipped.size(), 3U);
  EXPECT_THAT(sequence.skipped[0], HasSubstr("1000000000"));
  EXPECT_THAT(sequence.skipped[0], HasSubstr("moves"));
}

TEST(StereoSequence, ReadsRotationsThatAreWrittenInverselyTheRightWayRound) {
  std::string table;
  for (int i = 0; i <= 20; ++i) {
    Eigen::Isometry3d pose = upright(2);
    pose.linear() = (Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) * pose.linear()).transpose().eval();
    table += row(1000000000 + i * 50000000, pose);
  }
  const StereoFolder folder(table);
  const Sequence sequence = read_sequence(folder.path());
  EXPECT_TRUE(sequence.rotations_inverted);
  const Eigen::Vector3d down = sequence.frames[0].world_from_camera.linear().col(1);
  EXPECT_LT(down.z(), -0.9);
}

/// Looking along -y a camera stands nearly as upright in the inverse of its rotation as in the rotation
/// itself.
TEST(StereoSequence, TakesARightTableAsItIsWrittenWhereverTheCameraLooks) {
  const double degree = std::numbers::pi / 180;
  for (int yaw = -180; yaw < 180; yaw += 15) {
    for (const double roll : {-10.0, 0.0, 10.0}) {
      Eigen::Isometry3d pose = upright(2, 20 * degree);
      pose.linear() = Eigen::AngleAxisd(yaw * degree, Eigen::Vector3d::UnitZ()) * pose.linear() *
                      Eigen::AngleAxisd(roll * degree, Eigen::Vector3d::UnitZ());
      std::string table;
      for (int i = 0; i <= 20; ++i) table += row(1000000000 + i * 50000000, pose);
      const StereoFolder folder(table);
      const Sequence sequence = read_sequence(folder.path());
      EXPECT_FALSE(sequence.rotations_inverted) << "yaw " << yaw << ", roll " << roll;
      EXPECT_TRUE(sequence.frames[0].world_from_camera.isApprox(pose, 1e-6));
    }
  }
}

TEST(StereoSequence, NamesWhatIsMissing) {
  const TemporaryFolder empty;
  EXPECT_THAT(error_of([&] { read_sequence(empty / "none"); }), HasSubstr("no such folder"));
  EXPECT_THAT(error_of([&] { read_sequence(empty.path()); }), HasSubstr("holds no sequence"));
  const std::string table = standing_table(1, 2);
  {
    const StereoFolder folder(table);
    fs::remove(folder.path() / "cam1" / "data" / "1250000000.png");
    EXPECT_THAT(error_of([&] { read_sequence(folder.path()); }), HasSubstr("cam0 has 4 images and cam1 3"));
  }
  {
    const StereoFolder folder(table);
    fs::rename(folder.path() / "cam1/data/1250000000.png", folder.path() / "cam1/data/1260000000.png");
    EXPECT_THAT(error_of([&] { read_sequence(folder.path()); }), HasSubstr("1250000000.png: has no partner"));
  }
  {
    const StereoFolder folder(table);
    for (const char* cam : {"cam0", "cam1"}) {
      fs::rename(folder.path() / cam / "data/1250000000.png", folder.path() / cam / "data/left.png");
    }
    EXPECT_THAT(error_of([&] { read_sequence(folder.path()); }),
                HasSubstr("left.png: is not named by its stamp"));
  }
  {
    const StereoFolder folder(table);
    fs::remove(folder.path() / "left_cam_gt_X.csv");
    EXPECT_THAT(error_of([&] { read_sequence(folder.path()); }), HasSubstr("left_cam_gt"));
  }
  {
    const StereoFolder folder(table);
    fs::remove(folder.path() / "cam1" / "sensor.yaml");
    EXPECT_THAT(error_of([&] { read_sequence(folder.path()); }), HasSubstr("sensor.yaml"));
  }
  {
    const StereoFolder folder(standing_table(100, 101));
    EXPECT_THAT(error_of([&] { read_sequence(folder.path()); }), HasSubstr("no pair"));
  }
}

TEST(PoseTable, NamesTheLineOfWhatIsMalformed) {
  const TemporaryFolder folder;
  const fs::path csv = folder / "p.csv";
  const auto error = [&](const std::string& text) {
    write_text(csv, text);
    return error_of([&] { read_pose_table(csv); });
  };
  EXPECT_THAT(error("#head\n5,1,2,3,1,0,0,0\n6,1,2,3,1,0,0\n"),
              HasSubstr("p.csv:3: has 7 values, expected 8"));
  EXPECT_THAT(error("5,1,2,x,1,0,0,0\n"), HasSubstr("p.csv:1: 'x', expected a number"));
  EXPECT_THAT(error("5,1,2,nan,1,0,0,0\n"), HasSubstr("p.csv:1: 'nan', expected a number"));
  EXPECT_THAT(error("5,1,2,3,1,1,0,0\n"), HasSubstr("quaternion"));
  EXPECT_THAT(error("-5,1,2,3,1,0,0,0\n"), HasSubstr("nanoseconds"));
  EXPECT_THAT(error("5,1,2,3,1,0,0,0\n5,1,2,3,1,0,0,0\n"), HasSubstr("p.csv:2: its stamp is not later"));
  EXPECT_THAT(error("# nothing\n"), HasSubstr("holds no poses"));
  EXPECT_THAT(error("5,1e300,2,3,1,0,0,0\n"), HasSubstr("km"));
}

std::string matrix_text(const Eigen::Matrix4d& m) {
  std::string text;
  for (int r = 0; r < 4; ++r)
    text += fmt::format(" {:.7e}\t {:.7e}\t {:.7e}\t {:.7e}\t\n", m(r, 0), m(r, 1), m(r, 2), m(r, 3));
  return text;
}

RC_GTEST_PROP(PoseMatrix, ComesBackAsItWasWritten, ()) {
  const auto number = [](int most) { return *rc::gen::inRange(-most, most) * 1e-3; };
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(number(3000), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(number(3000), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() << number(9000), number(9000), number(9000);
  const TemporaryFolder folder;
  write_text(folder / "p.txt", matrix_text(pose.matrix()));
  RC_ASSERT(read_pose_matrix(folder / "p.txt").isApprox(pose, 1e-5));
}

TEST(PoseMatrix, IsRefusedWhenItIsNoRigidTransform) {
  const TemporaryFolder folder;
  const auto error = [&](const Eigen::Matrix4d& m) {
    write_text(folder / "p.txt", matrix_text(m));
    return error_of([&] { read_pose_matrix(folder / "p.txt"); });
  };
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  EXPECT_EQ(error(m), "no error");
  m(0, 0) = 2;
  EXPECT_THAT(error(m), HasSubstr("not a rotation"));
  m(0, 0) = -1;
  EXPECT_THAT(error(m), HasSubstr("not a rotation"));
  m = Eigen::Matrix4d::Identity();
  m(3, 0) = 1;
  EXPECT_THAT(error(m), HasSubstr("last row"));
}

TEST(Intrinsics, AreRefusedWhenTheyAreNoCameraMatrix) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& text) {
    write_text(folder / "k.txt", text);
    return error_of([&] { read_intrinsics(folder / "k.txt"); });
  };
  EXPECT_EQ(error("585 0 320\n0 585 240\n0 0 1\n"), "no error");
  EXPECT_THAT(error("585 0 320\n0 585 240\n"), HasSubstr("has 2 rows, expected 3"));
  EXPECT_THAT(error("585 0 320\n0 300 240\n0 0 1\n"), HasSubstr("differ"));
  EXPECT_THAT(error("585 1 320\n0 585 240\n0 0 1\n"), HasSubstr("skew"));
  EXPECT_THAT(error("-585 0 320\n0 -585 240\n0 0 1\n"), HasSubstr("focal"));
}

void write_depth_folder(const fs::path& folder, int frames) {
  write_text(folder / "camera-intrinsics.txt", "50 0 31.5\n0 50 23.5\n0 0 1\n");
  for (int i = 0; i < frames; ++i) {
    write_png(cv::Mat(48, 64, CV_16U, cv::Scalar(1500)), folder / fmt::format("frame-{:06}.depth.png", i));
    write_text(folder / fmt::format("frame-{:06}.pose.txt", i), matrix_text(upright(0.1 * i).matrix()));
  }
}

TEST(DepthSequence, KnowsItsCameraAndItsPoses) {
  const TemporaryFolder folder;
  write_depth_folder(folder.path(), 3);
  const Sequence sequence = read_sequence(folder.path());
  EXPECT_EQ(sequence.layout, Sequence::Layout::kDepth);
  ASSERT_EQ(sequence.frames.size(), 3U);
  EXPECT_EQ(sequence.frames[2].name, "frame-000002");
  EXPECT_TRUE(sequence.frames[2].world_from_camera.isApprox(upright(0.2), 1e-5));
  EXPECT_EQ(sequence.camera.width, 64);
  EXPECT_EQ(sequence.camera.height, 48);
  EXPECT_EQ(sequence.camera.focal, 50);
}

TEST(DepthSequence, NamesAMissingPose) {
  const TemporaryFolder folder;
  write_depth_folder(folder.path(), 3);
  fs::remove(folder / "frame-000001.pose.txt");
  EXPECT_THAT(error_of([&] { read_sequence(folder.path()); }),
              HasSubstr("frame-000001.pose.txt: no such file"));
}

std::string tum_row(double stamp, const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d t = pose.translation();
  return fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", stamp, t.x(), t.y(), t.z(),
                     q.x(), q.y(), q.z(), q.w());
}

/// Three images 0.1 s apart, poses 0.05 s apart, as TUM keeps them.
void write_tum_folder(const fs::path& folder) {
  fs::create_directories(folder / "depth");
  write_text(folder / "camera-intrinsics.txt", "50 0 31.5\n0 50 23.5\n0 0 1\n");
  std::string list = "# depth maps\n", poses = "# ground truth trajectory\n";
  for (int i = 0; i < 3; ++i) {
    write_png(cv::Mat(48, 64, CV_16U, cv::Scalar(7500)), folder / fmt::format("depth/{}.png", i));
    list += fmt::format("{:.4f} depth/{}.png\n", 1000.025 + 0.1 * i, i);
  }
  for (int i = 0; i < 8; ++i) poses += tum_row(1000 + 0.05 * i, upright(0.05 * i));
  write_text(folder / "depth.txt", list);
  write_text(folder / "groundtruth.txt", poses);
}

TEST(TumSequence, TakesPosesFromItsTable) {
  const TemporaryFolder folder;
  write_tum_folder(folder.path());
  const Sequence sequence = read_sequence(folder.path());
  EXPECT_EQ(sequence.layout, Sequence::Layout::kDepth);
  EXPECT_EQ(sequence.depth_per_metre, 5000);
  EXPECT_EQ(sequence.camera.width, 64);
  EXPECT_EQ(sequence.camera.focal, 50);
  ASSERT_EQ(sequence.frames.size(), 3U);
  EXPECT_EQ(sequence.frames[1].left, folder / "depth/1.png");
  EXPECT_EQ(sequence.frames[1].pose_source, PoseSource::kInterpolated);
  EXPECT_TRUE(sequence.frames[1].world_from_camera.isApprox(upright(0.125), 1e-6));
}

TEST(TumSequence, FindsTheDepthImagesInAListOfPairs) {
  for (const char* list : {"7.5 rgb/a.png 8.25 depth/b.png\n", "8.25 depth/b.png 7.5 rgb/a.png\n"}) {
    const TemporaryFolder folder;
    write_text(folder / "list.txt", list);
    const auto images = read_tum_images(folder / "list.txt");
    ASSERT_EQ(images.size(), 1U);
    EXPECT_EQ(images[0].stamp_ns, 8'250'000'000);
    EXPECT_EQ(images[0].image, folder / "depth/b.png");
  }
}

TEST(TumSequence, SaysWhatIsWrong) {
  const auto error = [&](const char* file, const char* text) {
    const TemporaryFolder folder;
    write_tum_folder(folder.path());
    text == nullptr ? static_cast<void>(fs::remove(folder / file)) : write_text(folder / file, text);
    return error_of([&] { read_sequence(folder.path()); });
  };
  EXPECT_THAT(error("camera-intrinsics.txt", nullptr), HasSubstr("camera-intrinsics.txt: no such file"));
  EXPECT_THAT(error("depth.txt", nullptr), HasSubstr("depth.txt: no such file"));
  EXPECT_THAT(error("depth.txt", "# none\n"), HasSubstr("names no images"));
  EXPECT_THAT(error("depth.txt", "1 depth/0.png 2\n"), HasSubstr("depth.txt:1: has 3 words"));
  EXPECT_THAT(error("depth.txt", "x depth/0.png\n"), HasSubstr("depth.txt:1: 'x', expected a number"));
  EXPECT_THAT(error("depth.txt", "-1 depth/0.png\n"), HasSubstr("expected a stamp in seconds"));
  EXPECT_THAT(error("depth.txt", "2 depth/0.png\n1 depth/1.png\n"), HasSubstr("depth.txt:2: its stamp"));
  EXPECT_THAT(error("depth.txt", "5 depth/0.png\n"), HasSubstr("no image of"));
  EXPECT_THAT(error("groundtruth.txt", "1000 0 0 0 0 0 1\n"), HasSubstr("expected 8: stamp [s]"));
  EXPECT_THAT(error("groundtruth.txt", "1000 0 0 0 0 0 0 2\n"), HasSubstr("quaternion has length 2"));
  EXPECT_THAT(error("depth/0.png", nullptr), HasSubstr("0.png"));
}

TEST(TumSequence, TurnsIclNuimsMirroredWorldRound) {
  const TemporaryFolder folder;
  write_tum_folder(folder.path());
  fs::remove(folder / "camera-intrinsics.txt");
  write_png(cv::Mat(480, 640, CV_16U, cv::Scalar(7500)), folder / "depth/0.png");
  write_text(folder / "depth.txt", "1 depth/0.png\n");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  pose.translation() << 0.1, 0.2, -2.25;
  write_text(folder / "groundtruth.txt", tum_row(1, pose));
  const Sequence sequence = read_sequence(folder.path());
  ASSERT_EQ(sequence.frames.size(), 1U);
  // A point of its camera with y up, in its world and turned round, and the same point as ours.
  const Eigen::Vector3d up(0.3, 0.5, 2), down(0.3, -0.5, 2);
  Eigen::Vector3d there = pose * up;
  there.y() *= -1;
  EXPECT_TRUE((sequence.frames[0].world_from_camera * down).isApprox(there, 1e-6));
}

/// One file of a good folder is cut or has bytes changed: the reader accepts it or says what is wrong.
template <class Write>
void mutate_and_read(const fs::path& file, std::uint64_t seed, const Write& read) {
  std::string bytes = read_text(file);
  std::mt19937_64 random(seed);
  if (random() % 3 == 0) bytes.resize(random() % (bytes.size() + 1));
  for (std::uint64_t i = random() % 6; i > 0 && !bytes.empty(); --i) {
    bytes[random() % bytes.size()] = static_cast<char>(random());
  }
  write_text(file, bytes);
  try {
    read();
  } catch (const InputError& e) {
    RC_ASSERT(std::string(e.what()).find('\n') == std::string::npos);
  }
}

RC_GTEST_PROP(BrokenSequences, NeverCrashTheStereoReader, (std::uint64_t seed)) {
  const StereoFolder folder(standing_table(1, 2));
  const fs::path files[] = {"left_cam_gt_X.csv", "cam0/sensor.yaml", "cam1/sensor.yaml"};
  mutate_and_read(folder.path() / files[seed % 3], seed, [&] { read_sequence(folder.path()); });
}

RC_GTEST_PROP(BrokenSequences, NeverCrashTheDepthReader, (std::uint64_t seed)) {
  const TemporaryFolder folder;
  write_depth_folder(folder.path(), 2);
  const fs::path files[] = {"camera-intrinsics.txt", "frame-000000.pose.txt", "frame-000000.depth.png"};
  mutate_and_read(folder.path() / files[seed % 3], seed, [&] { read_sequence(folder.path()); });
}

RC_GTEST_PROP(BrokenSequences, NeverCrashTheReaderOfTumsLayout, (std::uint64_t seed)) {
  const TemporaryFolder folder;
  write_tum_folder(folder.path());
  const fs::path files[] = {"camera-intrinsics.txt", "groundtruth.txt", "depth.txt", "depth/0.png"};
  mutate_and_read(folder.path() / files[seed % 4], seed, [&] { read_sequence(folder.path()); });
}

TEST(RealSequences, AreRead) {
  const char* data = std::getenv("HEADWAY_DATA");
  if (data == nullptr) GTEST_SKIP() << "HEADWAY_DATA is not set";
  const Sequence euroc = read_sequence(fs::path(data) / "sequence" / "euroc");
  EXPECT_EQ(euroc.frames.size(), 14U);
  EXPECT_TRUE(euroc.rotations_inverted);
  EXPECT_EQ(euroc.frames[0].pose_source, PoseSource::kNearest);
  EXPECT_NE(euroc.frames[8].pose_source, PoseSource::kNearest) << "the table has begun by then";
  // EuRoC's own body pose at that time puts the camera's forward axis there.
  EXPECT_TRUE(
      euroc.frames[5].world_from_camera.linear().col(2).isApprox(Eigen::Vector3d(0.916, 0.14, -0.377), 0.02));
  const Sequence room = read_sequence(fs::path(data) / "sequence" / "depth_room");
  EXPECT_EQ(room.frames.size(), 10U);
  EXPECT_EQ(room.camera.focal, 585);
}

}  // namespace
}  // namespace headway::app
