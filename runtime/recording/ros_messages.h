// The ROS 2 messages that a recording holds, field by field as common_interfaces, tf2_msgs and can_msgs
// define them, so that every viewer knows them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/time.h"

namespace headway::recording::ros {

struct Time {
  static constexpr std::string_view kName = "builtin_interfaces/msg/Time";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void fields(auto& self, auto&& visit) {
    visit("sec", self.sec);
    visit("nanosec", self.nanosec);
  }
};

/// Exact from 68 years before the clock's epoch to 68 years after.
inline Time stamp(headway::Time t) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(t);
  return {static_cast<std::int32_t>(whole.time_since_epoch().count()),
          static_cast<std::uint32_t>((t - whole).count())};
}
inline headway::Time time_of(const Time& t) {
  return headway::Time(std::chrono::seconds(t.sec) + Duration(t.nanosec));
}

struct Header {
  static constexpr std::string_view kName = "std_msgs/msg/Header";
  Time stamp;
  std::string frame_id;
  static void fields(auto& self, auto&& visit) {
    visit("stamp", self.stamp);
    visit("frame_id", self.frame_id);
  }
};

struct Point {
  static constexpr std::string_view kName = "geometry_msgs/msg/Point";
  double x = 0, y = 0, z = 0;  ///< [m]
  static void fields(auto& self, auto&& visit) {
    visit("x", self.x);
    visit("y", self.y);
    visit("z", self.z);
  }
};

struct Vector3 {
  static constexpr std::string_view kName = "geometry_msgs/msg/Vector3";
  double x = 0, y = 0, z = 0;  ///< [m]
  static void fields(auto& self, auto&& visit) {
    visit("x", self.x);
    visit("y", self.y);
    visit("z", self.z);
  }
};

struct Quaternion {
  static constexpr std::string_view kName = "geometry_msgs/msg/Quaternion";
  double x = 0, y = 0, z = 0, w = 1;
  static void fields(auto& self, auto&& visit) {
    visit("x", self.x);
    visit("y", self.y);
    visit("z", self.z);
    visit("w", self.w);
  }
};

struct Pose {
  static constexpr std::string_view kName = "geometry_msgs/msg/Pose";
  Point position;
  Quaternion orientation;
  static void fields(auto& self, auto&& visit) {
    visit("position", self.position);
    visit("orientation", self.orientation);
  }
};

struct PoseStamped {
  static constexpr std::string_view kName = "geometry_msgs/msg/PoseStamped";
  Header header;
  Pose pose;
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("pose", self.pose);
  }
};

struct Transform {
  static constexpr std::string_view kName = "geometry_msgs/msg/Transform";
  Vector3 translation;
  Quaternion rotation;
  static void fields(auto& self, auto&& visit) {
    visit("translation", self.translation);
    visit("rotation", self.rotation);
  }
};

struct TransformStamped {
  static constexpr std::string_view kName = "geometry_msgs/msg/TransformStamped";
  Header header;
  std::string child_frame_id;
  Transform transform;
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("child_frame_id", self.child_frame_id);
    visit("transform", self.transform);
  }
};

struct TfMessage {
  static constexpr std::string_view kName = "tf2_msgs/msg/TFMessage";
  std::vector<TransformStamped> transforms;
  static void fields(auto& self, auto&& visit) { visit("transforms", self.transforms); }
};

struct Path {
  static constexpr std::string_view kName = "nav_msgs/msg/Path";
  Header header;
  std::vector<PoseStamped> poses;
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("poses", self.poses);
  }
};

struct MapMetaData {
  static constexpr std::string_view kName = "nav_msgs/msg/MapMetaData";
  Time map_load_time;
  float resolution = 0;                 ///< edge of a cell [m]
  std::uint32_t width = 0, height = 0;  ///< cells
  Pose origin;                          ///< of the corner of cell (0, 0)
  static void fields(auto& self, auto&& visit) {
    visit("map_load_time", self.map_load_time);
    visit("resolution", self.resolution);
    visit("width", self.width);
    visit("height", self.height);
    visit("origin", self.origin);
  }
};

struct OccupancyGrid {
  static constexpr std::string_view kName = "nav_msgs/msg/OccupancyGrid";
  Header header;
  MapMetaData info;
  std::vector<std::int8_t> data;  ///< row-major from (0, 0): 0 free to 100 occupied, -1 unknown
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("info", self.info);
    visit("data", self.data);
  }
};

/// `Bytes`: a vector, or a span when it is only written.
template <class Bytes>
struct BasicImage {
  static constexpr std::string_view kName = "sensor_msgs/msg/Image";
  Header header;
  std::uint32_t height = 0, width = 0;  ///< [px]
  std::string encoding;                 ///< "mono8", or "32FC1": metres, NaN where nothing was measured
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;  ///< bytes of a row
  Bytes data;
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("height", self.height);
    visit("width", self.width);
    visit("encoding", self.encoding);
    visit("is_bigendian", self.is_bigendian);
    visit("step", self.step);
    visit("data", self.data);
  }
};
using Image = BasicImage<std::vector<std::uint8_t>>;
using ImageView = BasicImage<std::span<const std::uint8_t>>;

struct RegionOfInterest {
  static constexpr std::string_view kName = "sensor_msgs/msg/RegionOfInterest";
  std::uint32_t x_offset = 0, y_offset = 0, height = 0, width = 0;  ///< [px]
  bool do_rectify = false;
  static void fields(auto& self, auto&& visit) {
    visit("x_offset", self.x_offset);
    visit("y_offset", self.y_offset);
    visit("height", self.height);
    visit("width", self.width);
    visit("do_rectify", self.do_rectify);
  }
};

struct CameraInfo {
  static constexpr std::string_view kName = "sensor_msgs/msg/CameraInfo";
  Header header;
  std::uint32_t height = 0, width = 0;  ///< [px]
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{}, r{};  ///< row-major 3 x 3
  std::array<double, 12> p{};      ///< row-major 3 x 4
  std::uint32_t binning_x = 0, binning_y = 0;
  RegionOfInterest roi;
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("height", self.height);
    visit("width", self.width);
    visit("distortion_model", self.distortion_model);
    visit("d", self.d);
    visit("k", self.k);
    visit("r", self.r);
    visit("p", self.p);
    visit("binning_x", self.binning_x);
    visit("binning_y", self.binning_y);
    visit("roi", self.roi);
  }
};

struct CanFrame {
  static constexpr std::string_view kName = "can_msgs/msg/Frame";
  Header header;
  std::uint32_t id = 0;
  bool is_rtr = false, is_extended = false, is_error = false;
  std::uint8_t dlc = 0;
  std::array<std::uint8_t, 8> data{};
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("id", self.id);
    visit("is_rtr", self.is_rtr);
    visit("is_extended", self.is_extended);
    visit("is_error", self.is_error);
    visit("dlc", self.dlc);
    visit("data", self.data);
  }
};

}  // namespace headway::recording::ros
