// What the operator's page and other viewers may subscribe to.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "operator/messages.h"
#include "runtime/recording/cdr.h"

namespace headway::remote {

enum class Channel : std::uint8_t {
  kStatus,
  kPicture,
  kPoints,
  kMap,
  kPlan,
  kFootsteps,
  kTf,
  kField,
  kPreview,
  kVoxels,
  kPlanBody,
  kPreviewBody,
};

struct ChannelKind {
  std::string_view topic, schema;
  std::string (*text)();  ///< ros2msg
  /// Who subscribes gets the newest message at once, however old; of others, only what comes from then on.
  bool latched;
};

template <recording::CdrMessage T>
constexpr ChannelKind channel_of(std::string_view topic, bool latched) {
  return {topic, T::kName, &recording::ros2msg<T>, latched};
}

inline constexpr std::array<ChannelKind, 12> kChannels{{
    channel_of<OperatorStatus>("/headway/status", true),
    channel_of<ros::CompressedImage>("/camera/left", false),
    channel_of<ros::PointCloud2>("/points", false),
    channel_of<ros::OccupancyGrid>("/map", true),
    channel_of<ros::Path>("/plan", true),
    channel_of<ros::MarkerArray>("/footsteps", true),
    channel_of<ros::TfMessage>("/tf", true),
    channel_of<ros::MarkerArray>("/field", true),
    channel_of<ros::Path>("/preview", true),
    channel_of<Voxels>("/voxels", true),
    channel_of<ros::OccupancyGrid>("/plan/body", true),
    channel_of<ros::OccupancyGrid>("/preview/body", true),
}};
constexpr const ChannelKind& kind(Channel channel) { return kChannels[static_cast<std::size_t>(channel)]; }

}  // namespace headway::remote
