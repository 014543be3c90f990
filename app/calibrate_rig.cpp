#include "app/calibrate_rig.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/coverage_picture.h"
#include "app/drawing.h"
#include "app/image_pairs.h"
#include "app/report.h"
#include "hal/error.h"
#include "vision/image_files.h"
#include "vision/rig_files.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

std::string described(const vision::Board& board) {
  const std::string kind = board.markers ? "ChArUco board (" + board.markers->dictionary + ")" : "chessboard";
  return fmt::format("{} of {} x {} inner corners", kind, board.columns, board.rows);
}

/// The pairs in which both images show the board.
struct Seen {
  int width = 0, height = 0;
  std::vector<std::string> names, skipped;
  std::vector<vision::BoardPair> pairs;
};

class BoardSearch {
 public:
  explicit BoardSearch(const vision::Board& board) : board_(board) {}

  Seen run(const std::vector<ImagePair>& images) {
    Progress progress("looking for the board");
    for (const ImagePair& pair : images) {
      progress.show(done_++, images.size(), pair.name);
      add(pair);
    }
    if (seen_.pairs.empty()) {
      throw InputError(
          fmt::format("no {} is seen in both images of any of {} pairs ({}); check --board, and that "
                      "the whole board is in view and lit evenly",
                      described(board_), images.size(), seen_.skipped.front()));
    }
    return std::move(seen_);
  }

 private:
  void add(const ImagePair& pair) {
    const vision::BoardPair views{look(pair.left), look(pair.right)};
    const auto shared = vision::shared_corners(views.left, views.right);
    const auto skip = [&](const std::string& why) { seen_.skipped.push_back(pair.name + ": " + why); };
    if (views.left.empty()) return skip("no board in " + pair.left.filename().string());
    if (views.right.empty()) return skip("no board in " + pair.right.filename().string());
    if (!vision::shows_enough(board_, shared.left)) return skip("too few corners are seen by both cameras");
    seen_.names.push_back(pair.name);
    seen_.pairs.push_back(views);
  }

  vision::BoardView look(const fs::path& file) {
    const hal::GrayImage image = vision::read_gray(file);
    if (first_.empty()) first_ = file, seen_.width = image.width, seen_.height = image.height;
    if (image.width != seen_.width || image.height != seen_.height) {
      throw InputError(fmt::format("{}: has {} x {} px, expected {} x {} as {}", file.string(), image.width,
                                   image.height, seen_.width, seen_.height, first_.string()));
    }
    return vision::find_board(board_, image);
  }

  vision::Board board_;
  Seen seen_;
  fs::path first_;
  std::size_t done_ = 0;
};

Json summary(const vision::StereoCalibration& c) {
  return {{"rms_px", rounded(c.rms)},
          {"rms_of_each_camera_px", {rounded(c.left_rms), rounded(c.right_rms)}},
          {"epipolar_px",
           {{"mean", rounded(c.epipolar.mean)},
            {"rms", rounded(c.epipolar.rms)},
            {"largest", rounded(c.epipolar.largest)}}},
          {"square", {{"mean", rounded(c.square.mean)}, {"sigma", rounded(c.square.sigma)}}},
          {"baseline_m", rounded(c.rig.baseline(), 6)}};
}

Json of_estimates(const std::vector<vision::Estimate>& estimates) {
  Json out = Json::object();
  for (const vision::Estimate& e : estimates) {
    out[e.name] = {{"value", rounded(e.value, 7)}, {"sigma", rounded(e.sigma, 7)}};
    if (!e.unit.empty()) out[e.name]["unit"] = e.unit;
  }
  return out;
}

/// A pair stands out when any of its errors does.
std::vector<bool> outliers_of(const std::vector<vision::PairError>& errors) {
  std::vector<bool> out(errors.size(), false);
  for (const auto error :
       {&vision::PairError::left, &vision::PairError::right, &vision::PairError::epipolar}) {
    std::vector<double> values;
    for (const vision::PairError& e : errors) values.push_back(e.*error);
    const std::vector<bool> far = vision::standing_out(values);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = out[i] || far[i];
  }
  return out;
}

class RigCalibration {
 public:
  explicit RigCalibration(const RigCalibrationOptions& options) : options_(options) {}

  int run() {
    vision::require_usable(options_.board);
    if (!(options_.nearest < options_.farthest))
      throw InputError(fmt::format("--near {} and --far {}: expected the nearest depth below the farthest",
                                   options_.nearest, options_.farthest));
    const std::vector<ImagePair> images = find_image_pairs(options_.paths);
    make_folder(options_.out);
    seen_ = BoardSearch(options_.board).run(images);
    result_ = fit(options_.lenses);
    result_.rig.name = options_.name;
    result_.rig.nearest = options_.nearest, result_.rig.farthest = options_.farthest;
    vision::write_rig(result_.rig, options_.out / "rig.yaml");
    outliers_ = outliers_of(result_.pairs);
    write_png(coverage_picture(seen_.pairs, outliers_, seen_.width, seen_.height),
              options_.out / "coverage.png");
    describe(images.size());
    write_json(options_.out / "report.json", report_);
    return tell(images.size());
  }

 private:
  vision::StereoCalibration fit(vision::Lenses lenses) const {
    return vision::calibrate_stereo(options_.board, seen_.pairs, seen_.width, seen_.height, lenses);
  }

  void describe(std::size_t images) {
    const vision::Board& board = options_.board;
    report_["board"] = {{"columns", board.columns}, {"rows", board.rows}, {"square_m", board.square}};
    if (board.markers)
      report_["board"]["markers"] = {{"dictionary", board.markers->dictionary},
                                     {"size_m", board.markers->size}};
    report_["pairs_given"] = images;
    report_["pairs_used"] = seen_.pairs.size();
    report_["skipped"] = seen_.skipped;
    report_["lenses"] = options_.lenses == vision::Lenses::kAlike ? "alike" : "each";
    report_.update(summary(result_));
    report_["baseline_squares"] = rounded(result_.rig.baseline() / board.square);
    describe_pairs();
    report_["estimates"] = of_estimates(result_.estimates);
    const bool alike = options_.lenses == vision::Lenses::kAlike;
    report_[alike ? "if_each_lens_is_its_own" : "if_lenses_were_alike"] =
        comparison(alike ? vision::Lenses::kEach : vision::Lenses::kAlike);
  }

  /// The same corners under another assumption: what it costs, or would gain.
  Json comparison(vision::Lenses lenses) const {
    try {
      return summary(fit(lenses));
    } catch (const InputError& fault) {
      return fault.what();
    }
  }

  void describe_pairs() {
    Json covered = Json::object();
    for (const bool right : {false, true}) {
      std::vector<const vision::BoardView*> views;
      for (const auto& pair : seen_.pairs) views.push_back(right ? &pair.right : &pair.left);
      covered[right ? "right" : "left"] = rounded(coverage_of(views, seen_.width, seen_.height).share());
    }
    report_["coverage"] = covered;
    report_["outliers"] = Json::array();
    report_["pairs"] = Json::array();
    for (std::size_t i = 0; i < seen_.names.size(); ++i) {
      const vision::PairError& e = result_.pairs[i];
      report_["pairs"].push_back({{"name", seen_.names[i]},
                                  {"left_rms_px", rounded(e.left)},
                                  {"right_rms_px", rounded(e.right)},
                                  {"epipolar_rms_px", rounded(e.epipolar)}});
      if (outliers_[i]) report_["outliers"].push_back(seen_.names[i]);
    }
  }

  int tell(std::size_t images) const {
    std::string outliers;
    for (std::size_t i = 0; i < outliers_.size(); ++i) {
      if (outliers_[i]) outliers += (outliers.empty() ? "; stands out: " : ", ") + seen_.names[i];
    }
    fmt::print(
        "{}: rms {:.3f} px, epipolar error {:.3f} px (mean; rms {:.3f}), baseline {:.4f} m, from {} of {} "
        "pairs{}; "
        "rig.yaml, report.json, coverage.png\n",
        options_.out.string(), result_.rms, result_.epipolar.mean, result_.epipolar.rms,
        result_.rig.baseline(), seen_.pairs.size(), images, outliers);
    if (result_.epipolar.mean <= kLargestEpipolarError) return kSuccess;
    fmt::print(stderr,
               "headway: {}: rows differ by {:.2f} px on average, expected at most {} px; look at the pairs "
               "that stand "
               "out in report.json, and at the board's flatness\n",
               (options_.out / "rig.yaml").string(), result_.epipolar.mean, kLargestEpipolarError);
    return kNotReached;
  }

  RigCalibrationOptions options_;
  Seen seen_;
  vision::StereoCalibration result_;
  std::vector<bool> outliers_;
  Json report_ = Json::object();
};

}  // namespace

int calibrate_rig(const RigCalibrationOptions& options) { return RigCalibration(options).run(); }

}  // namespace headway::app
