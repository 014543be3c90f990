#include "vision/head_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "hal/angle.h"
#include "hal/head_kinematics.h"
#include "vision/calibration_file.h"

namespace headway::vision {

using config::Section;

namespace {

constexpr std::size_t kLongestName = 64;

// An ideal camera: square pixels, as many that `field_deg` spans the width from edge to edge.
CameraIntrinsics intrinsics_from(const Section& section) {
  CameraIntrinsics c;
  set_size(c, section, "size");
  const double field = section.number("field_deg", {5, 150, "deg"}) * kDegree;
  c.fx = c.fy = c.width / 2.0 / std::tan(field / 2);
  c.cx = (c.width - 1) / 2.0, c.cy = (c.height - 1) / 2.0;
  return c;
}

// Names become folders and stand in the comments of files: a plain file name, and each only once.
std::string name_from(const Section& section, std::set<std::string>& taken) {
  std::string name = section.text("name");
  const auto plain = [](unsigned char c) { return std::isgraph(c) != 0 && c != '/' && c != '\\'; };
  if (name.size() > kLongestName || name.front() == '.' || !std::all_of(name.begin(), name.end(), plain))
    section.fail("name", fmt::format("'{}', expected a plain file name of up to {} letters, digits and signs",
                                     name, kLongestName));
  if (!taken.insert(name).second) section.fail("name", fmt::format("'{}' is taken, expected another", name));
  return name;
}

HeadCamera camera_from(const Section& section, std::set<std::string>& taken) {
  HeadCamera camera;
  camera.name = name_from(section, taken);
  camera.intrinsics = intrinsics_from(section);
  const auto p = section.numbers("position", 3, {-1, 1, "m"});
  const double down = section.number("down_deg", {-90, 90, "deg"}) * kDegree;
  const double left = section.number_or("left_deg", 0, {-90, 90, "deg"}) * kDegree;
  camera.head_from_camera.translation() << p[0], p[1], p[2];
  camera.head_from_camera.linear() =
      Eigen::AngleAxisd(left, Eigen::Vector3d::UnitZ()).toRotationMatrix() * hal::body_from_optical(down);
  return camera;
}

std::size_t index_of(const std::vector<HeadCamera>& cameras, const Section& rig, std::string_view key) {
  const std::string name = rig.text(key);
  const auto named = [&](const HeadCamera& c) { return c.name == name; };
  const auto found = std::find_if(cameras.begin(), cameras.end(), named);
  if (found == cameras.end()) {
    std::vector<std::string> names;
    names.reserve(cameras.size());
    for (const HeadCamera& c : cameras) names.push_back(c.name);
    rig.fail(key, fmt::format("'{}', expected one of the cameras: {}", name, fmt::join(names, ", ")));
  }
  return static_cast<std::size_t>(found - cameras.begin());
}

HeadRig rig_from(const Section& section, const std::vector<HeadCamera>& cameras,
                 const std::vector<Section>& camera_sections, std::set<std::string>& taken) {
  const std::size_t l = index_of(cameras, section, "left"), r = index_of(cameras, section, "right");
  const HeadCamera &left = cameras[l], &right = cameras[r];
  HeadRig out;
  out.head_from_left = left.head_from_camera;
  StereoRig& rig = out.rig;
  rig.name = name_from(section, taken);
  rig.left = left.intrinsics, rig.right = right.intrinsics;
  rig.right_from_left = right.head_from_camera.inverse() * left.head_from_camera;
  rig.nearest = section.number("nearest", {0.05, 100, "m"});
  rig.farthest = section.number("farthest", {0.05, 1000, "m"});
  rig.disparity_sigma = section.number_or("disparity_sigma", rig.disparity_sigma, {0.01, 10, "px"});
  require_usable_at(
      {camera_sections[l], camera_sections[r], section, "size", "field_deg", "size", "field_deg", "right"},
      rig);
  return out;
}

}  // namespace

CameraHead read_head(const std::filesystem::path& file) {
  const Section section = Section::load(file, "head");
  CameraHead head;
  head.name = section.text("name");
  const auto cameras = section.sections("cameras"), rigs = section.sections("rigs");
  std::set<std::string> of_cameras, of_rigs;
  for (const Section& camera : cameras) head.cameras.push_back(camera_from(camera, of_cameras));
  for (const Section& rig : rigs) head.rigs.push_back(rig_from(rig, head.cameras, cameras, of_rigs));
  if (rigs.empty())
    section.fail("rigs", "none, expected a list of pairs of cameras (name, left, right, ...)");
  section.finish();
  return head;
}

}  // namespace headway::vision
