// The ROS 2 messages that only viewers see, beside those that a recording holds too: field by field as
// common_interfaces define them, and Headway's own.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/recording/ros_messages.h"

namespace headway::remote {

namespace ros {

using namespace recording::ros;

struct CompressedImage {
  static constexpr std::string_view kName = "sensor_msgs/msg/CompressedImage";
  Header header;
  std::string format;  ///< "jpeg"
  std::vector<std::uint8_t> data;
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("format", self.format);
    visit("data", self.data);
  }
};

struct PointField {
  static constexpr std::string_view kName = "sensor_msgs/msg/PointField";
  static constexpr std::uint8_t kFloat32 = 7;
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = kFloat32;
  std::uint32_t count = 1;
  static void fields(auto& self, auto&& visit) {
    visit("name", self.name);
    visit("offset", self.offset);
    visit("datatype", self.datatype);
    visit("count", self.count);
  }
};

struct PointCloud2 {
  static constexpr std::string_view kName = "sensor_msgs/msg/PointCloud2";
  Header header;
  std::uint32_t height = 1, width = 0;  ///< points
  std::vector<PointField> fields_of_points;
  bool is_bigendian = false;
  std::uint32_t point_step = 0, row_step = 0;  ///< [bytes]
  std::vector<std::uint8_t> data;
  bool is_dense = true;
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("height", self.height);
    visit("width", self.width);
    visit("fields", self.fields_of_points);
    visit("is_bigendian", self.is_bigendian);
    visit("point_step", self.point_step);
    visit("row_step", self.row_step);
    visit("data", self.data);
    visit("is_dense", self.is_dense);
  }
};

struct ColorRgba {
  static constexpr std::string_view kName = "std_msgs/msg/ColorRGBA";
  float r = 0, g = 0, b = 0, a = 1;  ///< 0 to 1
  static void fields(auto& self, auto&& visit) {
    visit("r", self.r);
    visit("g", self.g);
    visit("b", self.b);
    visit("a", self.a);
  }
};

/// builtin_interfaces/msg/Duration.
struct Lifetime {
  static constexpr std::string_view kName = "builtin_interfaces/msg/Duration";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  static void fields(auto& self, auto&& visit) {
    visit("sec", self.sec);
    visit("nanosec", self.nanosec);
  }
};

struct UvCoordinate {
  static constexpr std::string_view kName = "visualization_msgs/msg/UVCoordinate";
  float u = 0, v = 0;
  static void fields(auto& self, auto&& visit) {
    visit("u", self.u);
    visit("v", self.v);
  }
};

struct MeshFile {
  static constexpr std::string_view kName = "visualization_msgs/msg/MeshFile";
  std::string filename;
  std::vector<std::uint8_t> data;
  static void fields(auto& self, auto&& visit) {
    visit("filename", self.filename);
    visit("data", self.data);
  }
};

struct Marker {
  static constexpr std::string_view kName = "visualization_msgs/msg/Marker";
  static constexpr std::int32_t kCube = 1, kTriangleList = 11;
  static constexpr std::int32_t kAdd = 0, kDeleteAll = 3;
  Header header;
  std::string ns;
  std::int32_t id = 0, type = kCube, action = kAdd;
  Pose pose;
  Vector3 scale{1, 1, 1};  ///< [m]
  ColorRgba color;
  Lifetime lifetime;  ///< 0: for ever
  bool frame_locked = false;
  std::vector<Point> points;
  std::vector<ColorRgba> colors;
  std::string texture_resource;
  CompressedImage texture;
  std::vector<UvCoordinate> uv_coordinates;
  std::string text, mesh_resource;
  MeshFile mesh_file;
  bool mesh_use_embedded_materials = false;
  static void fields(auto& self, auto&& visit) {
    visit("header", self.header);
    visit("ns", self.ns);
    visit("id", self.id);
    visit("type", self.type);
    visit("action", self.action);
    visit("pose", self.pose);
    visit("scale", self.scale);
    visit("color", self.color);
    visit("lifetime", self.lifetime);
    visit("frame_locked", self.frame_locked);
    visit("points", self.points);
    visit("colors", self.colors);
    visit("texture_resource", self.texture_resource);
    visit("texture", self.texture);
    visit("uv_coordinates", self.uv_coordinates);
    visit("text", self.text);
    visit("mesh_resource", self.mesh_resource);
    visit("mesh_file", self.mesh_file);
    visit("mesh_use_embedded_materials", self.mesh_use_embedded_materials);
  }
};

struct MarkerArray {
  static constexpr std::string_view kName = "visualization_msgs/msg/MarkerArray";
  std::vector<Marker> markers;
  static void fields(auto& self, auto&& visit) { visit("markers", self.markers); }
};

}  // namespace ros

/// Somebody who looks on, as the server knows him.
struct ViewerStatus {
  static constexpr std::string_view kName = "headway_msgs/msg/ViewerStatus";
  std::uint32_t number = 0;
  std::string name;  ///< as he called himself when he took control; empty: not yet
  std::string role, address;
  bool has_control = false;
  std::uint64_t sent = 0, missed = 0;  ///< messages
  static void fields(auto& self, auto&& visit) {
    visit("number", self.number);
    visit("name", self.name);
    visit("role", self.role);
    visit("address", self.address);
    visit("has_control", self.has_control);
    visit("sent", self.sent);
    visit("missed", self.missed);
  }
};

/// All small numbers of the page.
struct OperatorStatus {
  static constexpr std::string_view kName = "headway_msgs/msg/OperatorStatus";
  std::int64_t stamp_ns = 0;  ///< the run's clock
  std::uint32_t number = 0;   ///< one more each time
  std::string state, reason, safety, safety_reason;
  double x = 0, y = 0, yaw = 0;                                   ///< of the base in the map [m, rad]
  double pan = 0, tilt = 0;                                       ///< [rad]
  double pan_low = 0, pan_high = 0, tilt_low = 0, tilt_high = 0;  ///< [rad]
  bool at_rest = true, has_goal = false;
  double goal_x = 0, goal_y = 0;
  bool goal_has_yaw = false;
  double goal_yaw = 0;
  bool paused = false;
  std::string next;  ///< what the robot will do next, for people
  std::string head, control_computer, frame_level;
  std::uint64_t frames = 0, frames_lost = 0, frames_no_pose = 0, frames_unusable = 0, frames_late = 0;
  double see_ms = 0, map_ms = 0, floor_ms = 0, plan_ms = 0;
  double frame_age_ms = -1;  ///< of the newest frame when this was written; negative before the first
  std::uint64_t bus_cycles = 0, bus_missed = 0;
  double bus_wake_max_us = 0, bus_load = 0;  ///< the load: 0 to 1; 0 where it is not known
  std::uint32_t plans = 0, replans = 0;
  bool recording = false;
  std::string lease_holder;  ///< empty: nobody
  std::uint32_t lease = 0;
  bool simulated = false;
  double speed = 1;  ///< of a simulation, against real time
  std::uint32_t clients = 0, tour_left = 0;
  bool exploring = false;
  std::vector<ViewerStatus> viewers;
  // Of the recording that is made:
  std::string record_folder;  ///< empty: nothing can be recorded
  std::string record_file;    ///< that is written, or was last
  double record_mib = 0;
  std::uint64_t record_dropped = 0;  ///< rows that there was no time to write
  std::string record_fault;          ///< why it did not begin, or ended by itself
  // Of a recording that is played:
  std::string recording_name;                            ///< empty: this is no recording
  double played_at = 0, played_from = 0, played_to = 0;  ///< the run's clock [s]
  double played_speed = 1;
  bool played_paused = false;
  static void fields(auto& self, auto&& visit) {
    visit("stamp_ns", self.stamp_ns);
    visit("number", self.number);
    visit("state", self.state);
    visit("reason", self.reason);
    visit("safety", self.safety);
    visit("safety_reason", self.safety_reason);
    visit("x", self.x);
    visit("y", self.y);
    visit("yaw", self.yaw);
    visit("pan", self.pan);
    visit("tilt", self.tilt);
    visit("pan_low", self.pan_low);
    visit("pan_high", self.pan_high);
    visit("tilt_low", self.tilt_low);
    visit("tilt_high", self.tilt_high);
    visit("at_rest", self.at_rest);
    visit("has_goal", self.has_goal);
    visit("goal_x", self.goal_x);
    visit("goal_y", self.goal_y);
    visit("goal_has_yaw", self.goal_has_yaw);
    visit("goal_yaw", self.goal_yaw);
    visit("paused", self.paused);
    visit("next", self.next);
    visit("head", self.head);
    visit("control_computer", self.control_computer);
    visit("frame_level", self.frame_level);
    visit("frames", self.frames);
    visit("frames_lost", self.frames_lost);
    visit("frames_no_pose", self.frames_no_pose);
    visit("frames_unusable", self.frames_unusable);
    visit("frames_late", self.frames_late);
    visit("see_ms", self.see_ms);
    visit("map_ms", self.map_ms);
    visit("floor_ms", self.floor_ms);
    visit("plan_ms", self.plan_ms);
    visit("frame_age_ms", self.frame_age_ms);
    visit("bus_cycles", self.bus_cycles);
    visit("bus_missed", self.bus_missed);
    visit("bus_wake_max_us", self.bus_wake_max_us);
    visit("bus_load", self.bus_load);
    visit("plans", self.plans);
    visit("replans", self.replans);
    visit("recording", self.recording);
    visit("lease_holder", self.lease_holder);
    visit("lease", self.lease);
    visit("simulated", self.simulated);
    visit("speed", self.speed);
    visit("clients", self.clients);
    visit("tour_left", self.tour_left);
    visit("exploring", self.exploring);
    visit("viewers", self.viewers);
    visit("record_folder", self.record_folder);
    visit("record_file", self.record_file);
    visit("record_mib", self.record_mib);
    visit("record_dropped", self.record_dropped);
    visit("record_fault", self.record_fault);
    visit("recording_name", self.recording_name);
    visit("played_at", self.played_at);
    visit("played_from", self.played_from);
    visit("played_to", self.played_to);
    visit("played_speed", self.played_speed);
    visit("played_paused", self.played_paused);
  }
};

/// Bricks of 8 x 8 x 8 voxels that have changed. A brick that was never sent is wholly unseen.
struct Voxels {
  static constexpr std::string_view kName = "headway_msgs/msg/Voxels";
  double resolution = 0;           ///< edge of a voxel [m]
  bool whole = false;              ///< all bricks sent before are to be forgotten
  std::vector<std::int32_t> keys;  ///< three a brick: (i, j, k) begins at voxel (8 i, 8 j, 8 k) of the map
  /// 64 bytes a brick: bit x of byte 8 z + y is its voxel (x, y, z).
  std::vector<std::uint8_t> occupied, unseen;
  static void fields(auto& self, auto&& visit) {
    visit("resolution", self.resolution);
    visit("whole", self.whole);
    visit("keys", self.keys);
    visit("occupied", self.occupied);
    visit("unseen", self.unseen);
  }
};

}  // namespace headway::remote
