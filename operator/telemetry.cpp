#include "operator/telemetry.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <turbojpeg.h>

#include "hal/error.h"
#include "operator/swept.h"
#include "runtime/recorded_values.h"

namespace headway::remote {

namespace {

constexpr int kJpegQuality = 80;
constexpr const char* kMap = "map";

ros::ColorRgba colour(const SeenFoot& foot) {
  // Left and right, as Okabe and Ito have them; what is committed is solid.
  const float alpha = foot.committed ? 1.0F : 0.55F;
  return foot.left ? ros::ColorRgba{0.0F, 0.45F, 0.7F, alpha} : ros::ColorRgba{0.9F, 0.6F, 0.0F, alpha};
}

bool same(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  return std::ranges::equal(
      a, b, [](const Pose2& p, const Pose2& q) { return p.x == q.x && p.y == q.y && p.yaw == q.yaw; });
}

/// Throws Error where the encoder refuses.
std::vector<std::uint8_t> jpeg(const hal::GrayImage& image) {
  struct End {
    void operator()(void* encoder) const { tjDestroy(encoder); }
  };
  const std::unique_ptr<void, End> encoder(tjInitCompress());
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int fault = tjCompress2(encoder.get(), image.pixels.data(), image.width, 0, image.height, TJPF_GRAY,
                                &bytes, &size, TJSAMP_GRAY, kJpegQuality, TJFLAG_FASTDCT);
  std::vector<std::uint8_t> out;
  if (fault == 0) out.assign(bytes, bytes + size);
  tjFree(bytes);
  if (fault != 0) throw Error(fmt::format("jpeg: {}", tjGetErrorStr2(encoder.get())));
  return out;
}

}  // namespace

Telemetry::Telemetry(const TelemetryConfig& config) : config_(config), onlooker_(config.onlooker) {
  put(Channel::kField, config.field);
  put(Channel::kPreview, path({}));
  put_swept(Channel::kPlanBody, {});
  put_swept(Channel::kPreviewBody, {});
}

template <class Message>
void Telemetry::put(Channel channel, const Message& message) {
  Newest& newest = newest_[static_cast<std::size_t>(channel)];
  newest.cdr = std::make_shared<const std::vector<std::byte>>(recording::to_cdr(message));
  newest.time = onlooker_.seen().exposure;
  ++newest.number;
}

void Telemetry::look(const Wanted& wanted) {
  const auto wants = [&](Channel channel) { return wanted[static_cast<std::size_t>(channel)]; };
  onlooker_.wish({wants(Channel::kPicture), wants(Channel::kPoints), true});
  onlooker_.update();
  for (SeenBrick brick; onlooker_.take(brick);) mirror_.take(brick);
  metrics_.update();
  if (status_.update()) put(Channel::kStatus, status_.value());
  if (preview_.update()) {
    put(Channel::kPreview, path(preview_.value()));
    put_swept(Channel::kPreviewBody, preview_.value());
  }
  for (std::size_t i = 0; i < kChannels.size(); ++i)
    if (wanted[i]) make(static_cast<Channel>(i));
}

/// Of what has come since it was made last.
void Telemetry::make(Channel channel) {
  const Seen& seen = onlooker_.seen();
  const std::uint64_t of = channel == Channel::kMap ? seen.floor_number : seen.number;
  std::uint64_t& made_of = made_of_[static_cast<std::size_t>(channel)];
  if (of == made_of) return;
  made_of = of;
  switch (channel) {
    case Channel::kPicture:
      if (!seen.picture.pixels.empty()) put(channel, picture());
      return;
    case Channel::kPoints:
      return put(channel, points());
    case Channel::kMap:
      return put(channel, seen.floor);
    case Channel::kPlan:
      return put(channel, path(seen.way));
    case Channel::kFootsteps:
      return put(channel, footsteps());
    case Channel::kTf:
      return put(channel, poses());
    case Channel::kPlanBody:
      if (same(seen.way, swept_)) return;
      swept_ = seen.way;
      return put_swept(channel, swept_);
    case Channel::kStatus:
    case Channel::kField:
    case Channel::kPreview:
    case Channel::kPreviewBody:
    case Channel::kVoxels:
      return;
  }
}

ros::Header Telemetry::header() const { return {ros::stamp(onlooker_.seen().exposure), kMap}; }

ros::Path Telemetry::path(const std::vector<Pose2>& way) const {
  ros::Path out;
  out.header = header();
  for (const Pose2& base : way)
    out.poses.push_back(runtime::pose_stamped(base, onlooker_.seen().exposure, kMap));
  return out;
}

void Telemetry::put_swept(Channel channel, const std::vector<Pose2>& way) {
  put(channel, swept_floor(way, config_.outline, config_.grid, onlooker_.seen().exposure));
}

ros::CompressedImage Telemetry::picture() const {
  ros::CompressedImage image;
  image.header = header();
  image.header.frame_id = "camera_left";
  image.format = "jpeg";
  image.data = jpeg(onlooker_.seen().picture);
  return image;
}

ros::PointCloud2 Telemetry::points() const {
  static_assert(sizeof(SeenPoint) == 20);
  const std::vector<SeenPoint>& points = onlooker_.seen().points;
  ros::PointCloud2 cloud;
  cloud.header = header();
  cloud.width = static_cast<std::uint32_t>(points.size());
  cloud.fields_of_points = {{"x", 0}, {"y", 4}, {"z", 8}, {"rgb", 12}, {"sigma", 16}};
  cloud.point_step = sizeof(SeenPoint);
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.data.resize(cloud.row_step);
  if (!points.empty()) std::memcpy(cloud.data.data(), points.data(), cloud.data.size());
  return cloud;
}

ros::MarkerArray Telemetry::footsteps() const {
  constexpr double kThick = 0.01;  // [m]
  ros::MarkerArray all;
  ros::Marker clear;
  clear.header = header();
  clear.action = ros::Marker::kDeleteAll;
  all.markers.push_back(clear);
  for (const SeenFoot& foot : onlooker_.seen().feet) {
    ros::Marker marker;
    marker.header = header();
    marker.ns = foot.committed ? "committed" : "planned";
    marker.id = static_cast<std::int32_t>(all.markers.size());
    marker.pose = runtime::pose_stamped(foot.at, onlooker_.seen().exposure, kMap).pose;
    marker.pose.position.z = kThick / 2;
    marker.scale = {config_.sole_length, config_.sole_width, kThick};
    marker.color = colour(foot);
    all.markers.push_back(std::move(marker));
  }
  return all;
}

ros::TfMessage Telemetry::poses() const {
  const Seen& seen = onlooker_.seen();
  ros::TfMessage tf;
  tf.transforms.push_back({header(), "base", runtime::transform(seen.base.lifted(0))});
  tf.transforms.push_back({header(), "chest", runtime::transform(seen.map_from_chest)});
  tf.transforms.push_back({header(), "camera_left", runtime::transform(seen.map_from_view)});
  return tf;
}

std::shared_ptr<const std::vector<std::byte>> Telemetry::voxels(std::uint64_t& version) {
  Voxels changed;
  changed.resolution = config_.resolution;
  if (!mirror_.since(version, changed)) return nullptr;
  return std::make_shared<const std::vector<std::byte>>(recording::to_cdr(changed));
}

/// The floor map as ROS's map_server reads it.
std::shared_ptr<const std::string> Telemetry::file(const std::string& name) {
  const ros::OccupancyGrid& floor = onlooker_.seen().floor;
  if (floor.data.empty()) return nullptr;
  const auto width = floor.info.width, height = floor.info.height;
  if (name == "map.yaml") {
    const ros::Point& origin = floor.info.origin.position;
    return std::make_shared<const std::string>(fmt::format(
        "image: map.pgm\nresolution: {:.6g}\norigin: [{:.6g}, {:.6g}, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
        "free_thresh: 0.196\n",
        floor.info.resolution, origin.x, origin.y));
  }
  if (name != "map.pgm") return nullptr;
  auto text = std::make_shared<std::string>(fmt::format("P5\n{} {}\n255\n", width, height));
  for (std::uint32_t y = height; y-- > 0;)
    for (std::uint32_t x = 0; x < width; ++x) {
      const std::int8_t cell = floor.data[std::size_t{y} * width + x];
      text->push_back(static_cast<char>(cell < 0 ? 205 : cell == 0 ? 254 : 0));
    }
  return text;
}

std::string Telemetry::metrics() { return metrics_.value(); }

}  // namespace headway::remote
