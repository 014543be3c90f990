#include "runtime/frame_tap.h"

#include <utility>

#include "runtime/recorded_values.h"

namespace headway::runtime {

namespace ros = recording::ros;

/// Where there is no room the row's number is used up all the same: the gap shows.
template <class Queue, class Message>
void FrameTap::put(Queue& queue, Topic topic, Time time, const Message& message) {
  const std::uint32_t number = next_[static_cast<std::size_t>(topic)]++;
  auto* slot = queue.take_empty();
  if (slot == nullptr) return;
  slot->topic = topic;
  slot->sequence = number;
  slot->time = time;
  slot->ticket = ticket_++;
  recording::append_cdr(message, slot->bytes);
  queue.hand_over(slot);
}

void FrameTap::put_image(Topic topic, Time exposure, std::uint32_t width, std::uint32_t height,
                         const char* encoding, std::span<const std::uint8_t> bytes) {
  ros::ImageView image;
  image.header = {ros::stamp(exposure), topic == Topic::kRight  ? "camera_right"
                                        : topic == Topic::kLeft ? "camera_left"
                                                                : "camera_view"};
  image.width = width;
  image.height = height;
  image.encoding = encoding;
  image.step = height > 0 ? static_cast<std::uint32_t>(bytes.size() / height) : 0;
  image.data = bytes;
  put(pictures_, topic, now_, image);
}

void FrameTap::took(const hal::StereoFrame& frame) {
  work_.frame.push_back(frame.sequence);
  for (const auto& [topic, image] : {std::pair{Topic::kLeft, &frame.left}, {Topic::kRight, &frame.right}})
    put_image(topic, frame.exposure, static_cast<std::uint32_t>(image->width),
              static_cast<std::uint32_t>(image->height), "mono8", image->pixels);
}

void FrameTap::took(const hal::DepthFrame& frame) {
  work_.frame.push_back(frame.sequence);
  put_image(Topic::kDepth, frame.exposure, static_cast<std::uint32_t>(frame.width),
            static_cast<std::uint32_t>(frame.height), "32FC1",
            {reinterpret_cast<const std::uint8_t*>(frame.depth.data()), frame.depth.size() * sizeof(float)});
}

void FrameTap::begins(Time now, FrameLevel level) {
  now_ = now;
  work_.now_ns = now.time_since_epoch().count();
  work_.chest.clear();
  work_.head.clear();
  work_.goals.clear();
  work_.looks.clear();
  work_.level = static_cast<std::uint8_t>(level);
  work_.frame.clear();
  work_.stopwatch_ns.clear();
  work_.report.clear();
  work_.order.clear();
  work_.floor_sum = floor_sum_ = 0;
}

void FrameTap::takes(const hal::ChestSample& sample) { work_.chest.push_back(to_recorded(sample)); }
void FrameTap::takes(const HeadSample& sample) { work_.head.push_back(to_recorded(sample)); }
void FrameTap::takes(const GoalOrder& order) { work_.goals.push_back(to_recorded(order)); }
void FrameTap::takes(const LookOrder& order) { work_.looks.push_back(to_recorded(order)); }

/// What took nothing in, made no order and had no frame at hand changed nothing: it is left out.
void FrameTap::ends(const MotionOrder* order, const BusReport& report, bool frame_waits) {
  const bool took = !work_.chest.empty() || !work_.head.empty() || !work_.goals.empty() ||
                    !work_.looks.empty() || !work_.frame.empty();
  if (order != nullptr) {
    work_.report.push_back(to_recorded(report));
    work_.order.push_back(to_recorded(*order));
    work_.floor_sum = floor_sum_;
  }
  if (took || order != nullptr || waited_ || frame_waits || first_) put(rows_, Topic::kWork, now_, work_);
  first_ = false;
  waited_ = frame_waits;
}

void FrameTap::see(const FrameSnapshot& snapshot) {
  floor_sum_ = sum_of(snapshot.mapper.floor());
  put_poses(snapshot);
  put_path(snapshot);
  put_mission(snapshot.mission);
  const bool changed = !map_put_ || (floor_sum_ != map_sum_ && now_ - map_at_ >= kMapEvery);
  if (!changed && !map_wanted_.load(std::memory_order_relaxed)) return;
  put(pictures_, Topic::kMap, now_, occupancy(snapshot.mapper.floor(), snapshot.stamp.exposure));
  map_wanted_ = false;
  map_put_ = true;
  map_sum_ = floor_sum_;
  map_at_ = now_;
}

void FrameTap::put_poses(const FrameSnapshot& snapshot) {
  const Time t = snapshot.stamp.exposure;
  ros::TfMessage poses;
  poses.transforms.push_back({{ros::stamp(t), "map"}, "chest", transform(snapshot.map_from_chest)});
  poses.transforms.push_back({{ros::stamp(t), "map"}, "camera_view", transform(snapshot.map_from_view)});
  put(rows_, Topic::kTf, now_, poses);
  put(rows_, Topic::kPose, now_, pose_stamped(snapshot.bus.committed.stance.base(), t, "map"));
}

void FrameTap::put_path(const FrameSnapshot& snapshot) {
  const auto& walk = snapshot.mission.walk();
  if (!walk && !path_put_) return;
  const Time t = snapshot.stamp.exposure;
  ros::Path path;
  path.header = {ros::stamp(t), "map"};
  if (walk)
    for (const Pose2& base : walk->walk.bases) path.poses.push_back(pose_stamped(base, t, "map"));
  put(rows_, Topic::kPath, now_, path);
  path_put_ = walk.has_value();
}

void FrameTap::put_mission(const Mission& mission) {
  const MissionCounters& n = mission.counters();
  recorded::Mission now{name(mission.state()), mission.reason(), n.plans, n.replans, n.threats, n.pauses,
                        n.look_arounds};
  const bool news = now.state != mission_.state || now.reason != mission_.reason ||
                    now.replans != mission_.replans || now.threats != mission_.threats;
  if (!news) return;
  put(rows_, Topic::kMission, now_, now);
  mission_ = std::move(now);
}

void FrameTap::set(const nav::Goal& goal, Time now) { put(rows_, Topic::kGoal, now, to_recorded(goal)); }

void FrameTap::count(recorded::Drops& drops) const {
  drops.pictures = pictures_.dropped();
  drops.rows = rows_.dropped();
}

}  // namespace headway::runtime
