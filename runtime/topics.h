// The topics of a recording: their names, and the messages that they hold.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/time.h"
#include "runtime/recorded_messages.h"
#include "runtime/recording/cdr.h"
#include "runtime/recording/ros_messages.h"

namespace headway::runtime {

enum class Topic : std::uint8_t {
  kCanReceived,
  kCanSent,
  kBus,
  kSteps,
  kWork,
  kGoal,
  kMission,
  kDrops,
  kLeft,
  kRight,
  kDepth,
  kLeftInfo,
  kRightInfo,
  kTf,
  kPose,
  kPath,
  kMap,
};

struct TopicKind {
  std::string_view name, schema;
  std::string (*text)();  ///< ros2msg
};

template <recording::CdrMessage T>
constexpr TopicKind topic_of(std::string_view name) {
  return {name, T::kName, &recording::ros2msg<T>};
}

inline constexpr std::array<TopicKind, 17> kTopics{{
    topic_of<recording::ros::CanFrame>("/can/received"),
    topic_of<recording::ros::CanFrame>("/can/sent"),
    topic_of<recorded::BusReport>("/headway/bus"),
    topic_of<recorded::Step>("/headway/steps"),
    topic_of<recorded::Work>("/headway/work"),
    topic_of<recorded::Goal>("/headway/goal"),
    topic_of<recorded::Mission>("/headway/mission"),
    topic_of<recorded::Drops>("/headway/drops"),
    topic_of<recording::ros::Image>("/camera/left/image"),
    topic_of<recording::ros::Image>("/camera/right/image"),
    topic_of<recording::ros::Image>("/camera/depth"),
    topic_of<recording::ros::CameraInfo>("/camera/left/camera_info"),
    topic_of<recording::ros::CameraInfo>("/camera/right/camera_info"),
    topic_of<recording::ros::TfMessage>("/tf"),
    topic_of<recording::ros::PoseStamped>("/headway/pose"),
    topic_of<recording::ros::Path>("/plan"),
    topic_of<recording::ros::OccupancyGrid>("/map"),
}};
constexpr const TopicKind& kind(Topic topic) { return kTopics[static_cast<std::size_t>(topic)]; }
constexpr bool is_picture(Topic t) { return t == Topic::kLeft || t == Topic::kRight || t == Topic::kDepth; }

/// One message of a recording.
struct Row {
  Topic topic{};
  std::uint32_t sequence = 0;  ///< within its topic; a gap is what was dropped
  Time time{};
  std::span<const std::byte> cdr;
};

}  // namespace headway::runtime
