#include "vision/sight_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/cv_image.h"
#include "vision/median.h"
#include "vision/piece_search.h"

namespace headway::vision {

namespace {

constexpr int kBlack = 4, kWhite = 251;
constexpr int kRowsOfAnotherRig =
    48;  // [px]: raw images of swapped cameras may differ by twice their misalignment
constexpr double kBlurredRows = 4;  // times the row error that passes where an image is blurred
constexpr double kBehind = 2;       // disparities so far beyond infinity [px] are not noise

// Mean size of the Laplacian over mean distance from the surroundings: both scale with the contrast.
double sharpness_of(const cv::Mat& image) {
  cv::Mat blurred, fine, coarse, smooth;
  cv::blur(image, smooth, {3, 3});
  cv::blur(image, blurred, {15, 15});
  cv::absdiff(image, smooth, fine);
  cv::absdiff(image, blurred, coarse);
  const double contrast = cv::mean(coarse)[0];
  return contrast > 0.5 ? cv::mean(fine)[0] / contrast : 0;
}

CameraSight sight_of(const hal::GrayImage& image, double texture) {
  std::array<int, 256> histogram{};
  for (const std::uint8_t grey : image.pixels) ++histogram[grey];
  const double all = static_cast<double>(image.pixels.size());
  CameraSight sight;
  for (int g = 0; g < 256; ++g) {
    const double share = histogram[static_cast<std::size_t>(g)] / all;
    sight.brightness += g * share;
    if (g <= kBlack) sight.black += share;
    if (g >= kWhite) sight.white += share;
  }
  sight.texture = texture;
  sight.sharpness = sharpness_of(as_mat(image));
  return sight;
}

PairSight pair_sight(const PieceSearch& search, const RectifiedRig& rig) {
  PairSight pair;
  pair.looked_for = search.looked_for;
  pair.found = static_cast<int>(search.found.size());
  std::vector<double> rows, sizes;
  int behind = 0;
  for (const PieceMatch& m : search.found) {
    rows.push_back(m.row), sizes.push_back(std::abs(m.row));
    behind += m.disparity + rig.disparity_offset < -kBehind;
  }
  pair.row_offset = median(rows), pair.row_error = median(sizes);
  if (pair.found > 0) pair.behind_infinity = static_cast<double>(behind) / pair.found;
  return pair;
}

class Judge {
 public:
  Judge(const SightConfig& config, SightReport& report) : c_(config), report_(report) {}

  void judge() {
    const CameraSight &l = report_.left, &r = report_.right;
    dark();
    covered("left", l, r);
    covered("right", r, l);
    saturated("left", l.white);
    saturated("right", r.white);
    blurred();
    together(report_.pair);
  }

 private:
  void find(SightFault fault, Severity severity, std::string what) {
    report_.findings.push_back({fault, severity, std::move(what)});
  }

  void dark() {
    const double brightest = std::max(report_.left.brightness, report_.right.brightness);
    if (brightest < c_.dark)
      find(SightFault::kCovered, Severity::kFault,
           fmt::format("both cameras are dark: mean grey value {:.1f}, expected {} and more", brightest,
                       c_.dark));
  }

  void covered(const char* side, const CameraSight& camera, const CameraSight& other) {
    if (other.texture < c_.other_texture || camera.texture >= c_.texture_warning * other.texture) return;
    const bool nothing = camera.texture <= c_.least_texture;
    find(SightFault::kCovered, nothing ? Severity::kFault : Severity::kWarning,
         fmt::format("the {} camera shows {}: texture in {:.0f} % of its image, the other has {:.0f} %; is "
                     "it covered?",
                     side, nothing ? "nothing" : "little", 100 * camera.texture, 100 * other.texture));
  }

  void saturated(const char* side, double white) {
    if (white < c_.white_warning) return;
    find(SightFault::kSaturated, white < c_.white_fault ? Severity::kWarning : Severity::kFault,
         fmt::format("{:.0f} % of the {} image is white, expected less than {:.0f} %", 100 * white, side,
                     100 * c_.white_warning));
  }

  void blurred() {
    const CameraSight &l = report_.left, &r = report_.right;
    if (std::min(l.texture, r.texture) <= c_.least_texture) return;  // nothing to be sharp
    const bool left_worse = l.sharpness < r.sharpness;
    const double worse = std::min(l.sharpness, r.sharpness), better = std::max(l.sharpness, r.sharpness);
    if (worse < c_.blur_warning * better)
      find(SightFault::kBlurred, worse < c_.blur_fault * better ? Severity::kFault : Severity::kWarning,
           fmt::format("the {} image is blurred: {:.2f} times as sharp as the other, expected {} and more",
                       left_worse ? "left" : "right", worse / better, c_.blur_warning));
    if (better < c_.least_sharpness)
      find(SightFault::kBlurred, Severity::kWarning,
           fmt::format("both images are blurred: sharpness {:.2f}, expected {} and more", better,
                       c_.least_sharpness));
  }

  void together(const PairSight& pair) {
    const bool covered = report_.has(SightFault::kCovered);  // which explains what is not found
    if (!covered && pair.looked_for >= c_.least_pieces && pair.found < c_.found_warning * pair.looked_for)
      find(SightFault::kDifferent,
           pair.found < c_.found_fault * pair.looked_for ? Severity::kFault : Severity::kWarning,
           fmt::format(
               "of {} pieces of the left image {} are found in the right one, expected {:.0f} % and more",
               pair.looked_for, pair.found, 100 * c_.found_warning));
    if (pair.found < c_.least_pieces) return;
    if (pair.behind_infinity > c_.behind_fault)
      find(SightFault::kSwapped, Severity::kFault,
           fmt::format(
               "{:.0f} % of the matches lie behind infinity: left and right are swapped, or the cameras have "
               "turned apart",
               100 * pair.behind_infinity));
    const bool blurred = report_.has(SightFault::kBlurred);  // then rows are not found precisely
    if (pair.row_error > (blurred ? kBlurredRows : 1) * c_.row_warning)
      find(SightFault::kDecalibrated, pair.row_error > c_.row_fault ? Severity::kFault : Severity::kWarning,
           fmt::format("partners lie {:.2f} px off their row, expected at most {}; calibrate the rig anew",
                       pair.row_error, c_.row_warning));
  }

  const SightConfig& c_;
  SightReport& report_;
};

/// What is wrong with how a pair fits together that is right when its images are exchanged, the gravest
/// first.
std::string deciding(const SightReport& given, const SightReport& exchanged) {
  const PairSight &a = given.pair, &b = exchanged.pair;
  if (given.has(SightFault::kSwapped))
    return fmt::format("{:.0f} % of the matches lie behind infinity, exchanged {:.0f} %",
                       100 * a.behind_infinity, 100 * b.behind_infinity);
  if (given.has(SightFault::kDecalibrated))
    return fmt::format("partners lie {:.2f} px off their row, exchanged {:.2f} px", a.row_error, b.row_error);
  return fmt::format("of {} pieces {} are found, exchanged {}", a.looked_for, a.found, b.found);
}

bool is_arrangement(const SightFinding& f) {
  return f.fault == SightFault::kDifferent || f.fault == SightFault::kDecalibrated ||
         f.fault == SightFault::kSwapped;
}

}  // namespace

bool SightReport::has(SightFault fault) const {
  return std::any_of(findings.begin(), findings.end(),
                     [&](const SightFinding& f) { return f.fault == fault; });
}

const SightFinding* SightReport::fault() const {
  const auto found = std::find_if(findings.begin(), findings.end(),
                                  [](const SightFinding& f) { return f.severity == Severity::kFault; });
  return found == findings.end() ? nullptr : &*found;
}

SightReport check_sight(const hal::GrayImage& left, const hal::GrayImage& right, const RectifiedRig& rig,
                        const SightConfig& config) {
  PieceSearch search = search_pieces(left, right, rig);
  if (static_cast<double>(search.found.size()) < config.found_warning * search.looked_for)
    if (PieceSearch wider = search_pieces(left, right, rig, kRowsOfAnotherRig);
        wider.found.size() > search.found.size())
      search = std::move(wider);
  SightReport report;
  report.left = sight_of(left, search.left_texture);
  report.right = sight_of(right, search.right_texture);
  report.pair = pair_sight(search, rig);
  Judge(config, report).judge();
  return report;
}

SightReport check_sight(const Rectifier& rectifier, const hal::StereoFrame& raw, const hal::GrayImage& left,
                        const hal::GrayImage& right, const SightConfig& config) {
  SightReport report = check_sight(left, right, rectifier.rig(), config);
  if (std::none_of(report.findings.begin(), report.findings.end(), is_arrangement)) return report;
  hal::GrayImage other_left, other_right;
  rectifier.rectify(raw.right, raw.left, other_left, other_right);
  const SightReport exchanged = check_sight(other_left, other_right, rectifier.rig(), config);
  if (exchanged.pair.found < config.least_pieces ||
      std::any_of(exchanged.findings.begin(), exchanged.findings.end(), is_arrangement))
    return report;
  const std::string evidence = deciding(report, exchanged);
  std::erase_if(report.findings, is_arrangement);
  report.findings.push_back(
      {SightFault::kSwapped, Severity::kFault, "left and right are swapped: " + evidence});
  return report;
}

}  // namespace headway::vision
