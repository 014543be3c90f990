#include "app/node_pictures.h"

#include <algorithm>

namespace headway::app {

NodePictures::NodePictures(const sim::World& world, const sim::StereoCameraModel& model,
                           const std::filesystem::path& left, const std::filesystem::path& right,
                           hal::Clock& clock)
    : clock_(clock),
      scene_(world),
      camera_(scene_, clock, model),
      left_(left),
      right_(right),
      thread_(runtime::ThreadId::kPictures, [this](const std::atomic<bool>& stop) { run(stop); }) {}

void NodePictures::run(const std::atomic<bool>& stop) {
  while (!stop) {
    if (exposures_.update()) {
      const Exposure& exposure = exposures_.value();
      scene_.set_state(exposure.world);
      camera_.expose(exposure.at, exposure.map_from_left);
    }
    if (camera_.take_newest(frame_)) {
      left_.offer(frame_.left);
      right_.offer(frame_.right);
    }
    left_.pump();
    right_.pump();
    written_ = std::min(left_.written(), right_.written());
    clock_.sleep_until(clock_.now() + seconds(0.001));
  }
}

}  // namespace headway::app
