#include "app/frames_report.h"

namespace headway::app {

Json frames_json(const runtime::FrameLoopCounters& frames) {
  Json levels;
  for (std::size_t i = 0; i < runtime::kFrameLevels; ++i)
    levels[name(static_cast<runtime::FrameLevel>(i))] = frames.at_level[i];
  return {{"used", frames.frames},        {"lost", frames.lost}, {"no_pose", frames.no_pose},
          {"unusable", frames.unusable},  {"late", frames.late}, {"left_out", frames.left_out},
          {"at_level", std::move(levels)}};
}

}  // namespace headway::app
