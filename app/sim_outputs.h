// What a simulated run leaves behind: reports, pictures, the map and the cloud.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "app/output_folder.h"
#include "app/pictures.h"
#include "app/report.h"
#include "app/sim_session.h"
#include "app/walk_cost.h"
#include "nav/cloud_file.h"

namespace headway::app {

/// The report of a run, as report.json holds it (without wall-clock times).
Json sim_report(const SimSession& session, const SimOutcome& outcome);

/// Watches a run and writes its files at the end, if asked: the folder's owner says where.
class SimOutputs {
 public:
  explicit SimOutputs(SimSession& session);

  void see(const runtime::FrameSnapshot& snapshot);
  void write(const SimOutcome& outcome, OutputFolder& folder);
  /// What it may write besides the report.
  static constexpr std::initializer_list<const char*> kNames{
      "scene.png",  "views.png",  "left.png",  "depth.png",       "uncertainty.png", "plan.png",
      "replan.png", "floor.png",  "map.png",   "replan_left.png", "map.bt",          "map.hmap",
      "floor.pgm",  "floor.yaml", "cloud.ply", "timing.json"};

  const WalkCost& walk_cost() const { return walk_cost_; }

 private:
  struct Picture {
    std::string name;
    cv::Mat image;
  };
  void take_view(const runtime::FrameSnapshot& snapshot);
  void take_walk(const runtime::FrameSnapshot& snapshot);
  void keep_replan(const runtime::FrameSnapshot& snapshot);
  cv::Mat floor(const runtime::Mapper& mapper, const runtime::Mission& mission, const runtime::BusReport& bus,
                const std::string& title, std::vector<Eigen::Vector2d> former_path = {}) const;
  std::vector<FootPrint> walked_feet() const;
  FloorLayers layers() const;

  SimSession& session_;
  std::vector<Picture> pictures_, replan_;
  std::vector<Eigen::Vector2d> last_path_;
  double replan_change_ = 0;
  std::vector<cv::Mat> views_;
  std::vector<std::string> captions_;
  nav::CloudFile cloud_;
  std::size_t views_taken_ = 0;
  int replans_ = 0;
  bool walked_ = false;
  std::vector<double> see_ms_, map_ms_, floor_ms_, plan_ms_, total_ms_;
  WalkCost walk_cost_;
  Stopwatch wall_;
};

}  // namespace headway::app
