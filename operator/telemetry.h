// Makes messages of what the loops and the main loop show; for the server's thread.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/exchange.h"
#include "nav/body_outline.h"
#include "operator/seen.h"
#include "operator/source.h"
#include "operator/voxel_mirror.h"

namespace headway::remote {

/// What the robot's frames are to viewers, and how large its feet are.
struct TelemetryConfig {
  double resolution = 0.05;                      ///< of the voxels [m]
  double sole_length = 0.22, sole_width = 0.14;  ///< [m]
  nav::BodyOutline outline;                      ///< of the body
  nav::FloorGrid grid;                           ///< of the floor in use
  ros::MarkerArray field;                        ///< what the rig can see, in frame camera_left
  Onlooker::Config onlooker{};
};

class Telemetry final : public Source {
 public:
  explicit Telemetry(const TelemetryConfig& config);

  /// In the frame loop's thread.
  void see(const runtime::FrameSnapshot& snapshot) { onlooker_.see(snapshot); }
  /// What comes next is another run.
  void begin_again() { onlooker_.begin_again(); }

  // In the main loop's:
  void tell(const OperatorStatus& status) { status_.publish(status); }
  /// The way that is previewed; none: empty.
  void preview(const std::vector<Pose2>& way) { preview_.publish(way); }
  void tell_metrics(const std::string& text) { metrics_.publish(text); }

  // In the server's:
  void look(const Wanted& wanted) override;
  Newest newest(Channel channel) const override { return newest_[static_cast<std::size_t>(channel)]; }
  std::uint32_t status_number() const override { return status_.value().number; }
  std::shared_ptr<const std::vector<std::byte>> voxels(std::uint64_t& version) override;
  std::shared_ptr<const std::string> file(const std::string& name) override;
  std::string metrics() override;

 private:
  void make(Channel channel);
  void make_status();
  ros::CompressedImage picture() const;
  ros::PointCloud2 points() const;
  ros::MarkerArray footsteps() const;
  ros::TfMessage poses() const;
  ros::Header header() const;
  ros::Path path(const std::vector<Pose2>& way) const;
  void put_swept(Channel channel, const std::vector<Pose2>& way);
  template <class Message>
  void put(Channel channel, const Message& message);

  TelemetryConfig config_;
  Onlooker onlooker_;
  hal::NewestSlot<OperatorStatus> status_;
  hal::NewestSlot<std::vector<Pose2>> preview_;
  hal::NewestSlot<std::string> metrics_;
  VoxelMirror mirror_;
  std::array<Newest, kChannels.size()> newest_;
  std::array<std::uint64_t, kChannels.size()> made_of_{};  ///< numbers of what they were made of last
  std::vector<Pose2> swept_;                               ///< the way whose body was put last
};

}  // namespace headway::remote
