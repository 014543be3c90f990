#include "app/calibrate_rig.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/coverage_picture.h"
#include "app/drawing.h"
#include "app/image_pairs.h"
#include "app/output_folder.h"
#include "app/report.h"
#include "app/standard_streams.h"
#include "hal/error.h"
#include "vision/calibration_gaps.h"
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
  std::vector<std::string> skipped;
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
      throw InputError(fmt::format(
          "no {} is seen in both images of {} ({}); check --board, and that the whole board is in "
          "view and lit evenly",
          described(board_),
          images.size() == 1 ? "the only pair" : fmt::format("any of {} pairs", images.size()),
          seen_.skipped.front()));
    }
    if (seen_.pairs.size() < vision::kFewestViews && !seen_.skipped.empty()) {
      throw InputError(fmt::format(
          "only {} of {} pairs can be used, expected at least {} ({}); take more pairs with the "
          "board well inside both images",
          seen_.pairs.size(), images.size(), vision::kFewestViews, fmt::join(seen_.skipped, "; ")));
    }
    return std::move(seen_);
  }

 private:
  void add(const ImagePair& pair) {
    const vision::BoardPair views{look(pair.left), look(pair.right), pair.name};
    const auto shared = vision::shared_corners(views.left, views.right);
    const auto skip = [&](const std::string& why) { seen_.skipped.push_back(pair.name + ": " + why); };
    for (const auto& [view, file] : {std::pair{&views.left, pair.left}, {&views.right, pair.right}}) {
      if (view->empty())
        return skip((board_.markers ? fmt::format("fewer than {} corners in ", vision::kFewestCorners)
                                    : "no board in ") +
                    file.filename().string());
    }
    if (!vision::shows_enough(board_, shared.left))
      return skip(fmt::format("both cameras see {} of the same corners, expected {} or more, not in one line",
                              shared.left.size(), vision::kFewestCorners));
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

constexpr std::array<std::pair<const char*, vision::BoardView vision::BoardPair::*>, 2> kSides{
    {{"left", &vision::BoardPair::left}, {"right", &vision::BoardPair::right}}};

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
    seen_ = BoardSearch(options_.board).run(images);
    out_.emplace(options_.out, "calibrate");
    outliers_.assign(seen_.pairs.size(), false);
    write_coverage();  // it tells most where the fit fails
    try {
      result_ = fit(options_.lenses);
    } catch (const vision::UndeterminedLens& fault) {
      out_->keep();
      throw InputError(
          fmt::format("{}; {} shows where it was", fault.what(), (options_.out / "coverage.png").string()));
    }
    result_.rig.name = options_.name;
    result_.rig.nearest = options_.nearest, result_.rig.farthest = options_.farthest;
    vision::write_rig(result_.rig, out_->file("rig.yaml"));
    outliers_ = outliers_of(result_.pairs);
    write_coverage();
    describe(images.size());
    out_->report(report_);
    return tell(images.size());
  }

 private:
  void write_coverage() {
    write_png(coverage_picture(seen_.pairs, outliers_, seen_.width, seen_.height),
              out_->file("coverage.png"));
  }

  std::vector<std::string> unseen(vision::BoardView vision::BoardPair::*side) const {
    return vision::unseen_corners(views_of(seen_.pairs, side), seen_.width, seen_.height);
  }

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
    Json covered = Json::object(), never = Json::object();
    for (const auto& [name, side] : kSides) {
      covered[name] = rounded(coverage_of(views_of(seen_.pairs, side), seen_.width, seen_.height).share());
      never[name] = unseen(side);
    }
    report_["coverage"] = covered;
    report_["corners_of_the_image_never_covered"] = never;
    report_["outliers"] = Json::array();
    report_["pairs"] = Json::array();
    for (std::size_t i = 0; i < seen_.pairs.size(); ++i) {
      const vision::PairError& e = result_.pairs[i];
      report_["pairs"].push_back({{"name", seen_.pairs[i].name},
                                  {"left_rms_px", rounded(e.left)},
                                  {"right_rms_px", rounded(e.right)},
                                  {"epipolar_rms_px", rounded(e.epipolar)}});
      if (outliers_[i]) report_["outliers"].push_back(seen_.pairs[i].name);
    }
  }

  int tell(std::size_t images) const {
    std::string outliers;
    for (std::size_t i = 0; i < outliers_.size(); ++i) {
      if (outliers_[i]) outliers += (outliers.empty() ? "; stands out: " : ", ") + seen_.pairs[i].name;
    }
    fmt::print(
        "{}; rms {:.3f} px, epipolar error {:.3f} px (mean; rms {:.3f}), baseline {:.4f} m, from {} of {} "
        "pairs{}{}\n",
        out_->list(), result_.rms, result_.epipolar.mean, result_.epipolar.rms, result_.rig.baseline(),
        seen_.pairs.size(), images,
        seen_.skipped.empty() ? "" : fmt::format(" (left out: {})", fmt::join(seen_.skipped, "; ")),
        outliers);
    for (const auto& [name, side] : kSides) {
      if (const auto corners = unseen(side); !corners.empty())
        say_error(
            "headway: {}: the {} camera never saw the board near the {} of its image: its lens is a "
            "guess there\n",
            (options_.out / "rig.yaml").string(), name, fmt::join(corners, ", "));
    }
    if (result_.epipolar.mean <= kLargestEpipolarError) return kSuccess;
    say_error(
        "headway: {}: rows differ by {:.2f} px on average, expected at most {} px; look at the pairs "
        "that stand "
        "out in report.json, and at the board's flatness\n",
        (options_.out / "rig.yaml").string(), result_.epipolar.mean, kLargestEpipolarError);
    return kNotReached;
  }

  RigCalibrationOptions options_;
  std::optional<OutputFolder> out_;
  Seen seen_;
  vision::StereoCalibration result_;
  std::vector<bool> outliers_;
  Json report_ = Json::object();
};

}  // namespace

int calibrate_rig(const RigCalibrationOptions& options) { return RigCalibration(options).run(); }

}  // namespace headway::app
