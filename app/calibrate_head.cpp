#include "app/calibrate_head.h"

#include <cmath>
#include <fstream>
#include <optional>
#include <ostream>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/drawing.h"
#include "app/head_views_picture.h"
#include "app/image_pairs.h"
#include "app/neck_file.h"
#include "app/output_folder.h"
#include "app/pose_files.h"
#include "app/report.h"
#include "app/robot_file.h"
#include "app/standard_streams.h"
#include "hal/angle.h"
#include "hal/error.h"
#include "nav/whole_file.h"
#include "vision/calibration_errors.h"
#include "vision/image_files.h"
#include "vision/rig_files.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

/// As people read it: degrees, millimetres, milliseconds.
struct Readable {
  double factor;
  const char* unit;
};
Readable readable(const std::string& unit) {
  if (unit == "rad") return {1 / kDegree, "deg"};
  if (unit == "m") return {1000, "mm"};
  return {1000, "ms"};
}

class HeadCalibrationRun {
 public:
  explicit HeadCalibrationRun(const HeadCalibrationOptions& options) : options_(options) {}

  int run() {
    read();
    result_ = vision::calibrate_head(input_);
    outliers_ = vision::standing_out(result_.view_rms);
    out_.emplace(options_.out, "calibrate --head");
    write();
    return tell();
  }

 private:
  void read() {
    const vision::StereoRig rig = vision::read_rig(options_.rig);
    input_.board = options_.board, input_.camera = rig.left, input_.corner = options_.corner;
    input_.neck = read_robot(options_.robot).mission.neck;
    const std::vector<fs::path> images = images_in(options_.folder);
    if (images.empty())
      throw InputError(options_.folder.string() +
                       ": holds no images, expected them named by their stamp [ns]");
    input_.samples = read_head_table(options_.folder / "head.csv");
    images_ = images.size();
    Progress progress("looking for the board");
    for (std::size_t i = 0; i < images.size(); ++i) {
      progress.show(i, images.size(), images[i].filename().string());
      look(images[i]);
    }
    if (input_.views.empty()) {
      throw InputError(fmt::format(
          "{}: none of {} images can be used ({}); expected a board of {} x {} inner corners "
          "and head samples around each exposure",
          options_.folder.string(), images_, skipped_.front(), options_.board.columns, options_.board.rows));
    }
  }

  void look(const fs::path& file) {
    const Time exposure{Duration(stamp_of_image(file))};
    const hal::GrayImage image = vision::read_gray(file);
    if (image.width != input_.camera.width || image.height != input_.camera.height) {
      throw InputError(fmt::format("{}: has {} x {} px, expected {} x {} as {}", file.string(), image.width,
                                   image.height, input_.camera.width, input_.camera.height,
                                   options_.rig.string()));
    }
    const std::string name = file.filename().string();
    if (!vision::samples_cover(input_.samples, exposure)) {
      skipped_.push_back(name + ": no head samples around it");
      return;
    }
    vision::BoardView view = vision::find_board(options_.board, image);
    if (view.empty()) {
      skipped_.push_back(name + ": no board");
      return;
    }
    names_.push_back(name);
    input_.views.push_back({exposure, std::move(view)});
  }

  void write() {
    nav::write_whole(out_->file("neck.yaml"), [&](std::ostream& out) {
      out << "# For the section of the same name in the robot file, in place of the keys that are there.\n"
          << neck_text(result_.neck, result_.time_offset);
    });
    std::vector<HeadViewMark> marks;
    for (std::size_t i = 0; i < names_.size(); ++i)
      marks.push_back({result_.view_angles[i], result_.view_rms[i], outliers_[i]});
    write_png(head_views_picture(marks), out_->file("views.png"));
    out_->report(report());
  }

  Json report() const {
    Json out = Json::object();
    out["images"] = images_;
    out["views_used"] = names_.size();
    out["skipped"] = skipped_;
    out["rms_px"] = rounded(result_.rms);
    out["estimates"] = Json::object();
    for (const vision::Estimate& e : result_.estimates) {
      const Readable as = readable(e.unit);
      out["estimates"][e.name] = {{"value", rounded(as.factor * e.value)},
                                  {"sigma", rounded(as.factor * e.sigma)},
                                  {"unit", as.unit}};
    }
    out["frame"] =
        "camera.* are changes against the robot file, in the tilt link's frame; time_offset is to be added "
        "to the camera's stamps";
    out["held"] = {{"camera.turn_y",
                    "a turn about the tilt axis cannot be told from the tilt zero, which counts all of it"}};
    if (!options_.corner)
      out["held"]["pan_zero"] =
          "cannot be told from the board's unknown place around the pan axis; give --corner";
    out["outliers"] = Json::array();
    out["views"] = Json::array();
    for (std::size_t i = 0; i < names_.size(); ++i) {
      out["views"].push_back({{"image", names_[i]},
                              {"pan_deg", rounded(result_.view_angles[i].pan / kDegree, 3)},
                              {"tilt_deg", rounded(result_.view_angles[i].tilt / kDegree, 3)},
                              {"rms_px", rounded(result_.view_rms[i])}});
      if (outliers_[i]) out["outliers"].push_back(names_[i]);
    }
    return out;
  }

  int tell() const {
    std::string found;
    for (const vision::Estimate& e : result_.estimates) {
      const Readable as = readable(e.unit);
      found +=
          fmt::format(", {} {:.2f} +- {:.2f} {}", e.name, as.factor * e.value, as.factor * e.sigma, as.unit);
    }
    fmt::print("{}; rms {:.3f} px over {} of {} images{}{}\n", out_->list(), result_.rms, names_.size(),
               images_, found, options_.corner ? "" : "; pan zero held, give --corner to find it");
    if (result_.rms <= kLargestHeadError) return kSuccess;
    say_error(
        "headway: {}: corners are {:.2f} px from where they should be, expected at most {} px; did "
        "the board or "
        "the chest move, is this the rig's left camera, is the robot file this robot's?\n",
        (options_.out / "neck.yaml").string(), result_.rms, kLargestHeadError);
    return kNotReached;
  }

  HeadCalibrationOptions options_;
  std::optional<OutputFolder> out_;
  vision::HeadCalibrationInput input_;
  vision::HeadCalibration result_;
  std::vector<std::string> names_, skipped_;
  std::vector<bool> outliers_;
  std::size_t images_ = 0;
};

}  // namespace

int calibrate_head_of(const HeadCalibrationOptions& options) { return HeadCalibrationRun(options).run(); }

}  // namespace headway::app
