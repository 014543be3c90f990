// headway characterise: what a rig can see, and how precisely, before it has seen anything.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/drawing.h"
#include "app/finite_range.h"
#include "app/mesh_files.h"
#include "app/report.h"
#include "app/rig_pictures.h"
#include "app/robot_file.h"
#include "app/surface_picture.h"
#include "hal/error.h"
#include "vision/calibration_file.h"
#include "vision/characterise.h"
#include "vision/head_file.h"
#include "vision/image_files.h"
#include "vision/rectify.h"
#include "vision/rig_files.h"
#include "vision/stereo.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFarAway = 1e6;  // [m] as good as infinity
constexpr const char* kFrame = "rectified left camera, optical: x right, y down, z forward; metres";

struct CharacteriseOptions {
  fs::path rig, robot = default_robot_file();
  std::optional<fs::path> out;
  std::vector<double> resolutions{0.005, 0.02, 0.05};
  std::vector<fs::path> pair;
};

Json angles_json(const vision::FieldAngles& a) {
  return {{"horizontal_deg", rounded(a.horizontal / kDegree, 2)},
          {"vertical_deg", rounded(a.vertical / kDegree, 2)}};
}

Json vector_json(const Eigen::VectorXd& v, int decimals = 6) {
  Json out = Json::array();
  for (const double x : v) out.push_back(rounded(x, decimals));
  return out;
}

Json polytope_json(const vision::Polytope& polytope) {
  Json rows = Json::array(), corners = Json::array();
  for (const auto& row : polytope.rows) rows.push_back(vector_json(row));
  for (const auto& corner : polytope.corners) corners.push_back(vector_json(corner));
  return {{"rows", rows}, {"corners_m", corners}};
}

/// A tour of the head and how much it shows, far away and at one metre.
struct CoveredTour {
  std::string laid_out_for;
  std::vector<hal::HeadAngles> views;
  vision::CoveredShares far_away, at_a_metre;
};

class Characterisation {
 public:
  /// `tilt_from_left`: where the rig's left camera sits, unless that is where the robot's own one does.
  Characterisation(const CharacteriseOptions& options, const vision::StereoRig& rig,
                   const std::optional<Eigen::Isometry3d>& tilt_from_left = std::nullopt)
      : options_(options), raw_(rig), robot_(read_robot(options.robot)) {
    if (tilt_from_left) robot_.mission.neck.tilt_from_camera = *tilt_from_left;
    const vision::Rectifier rectifier(raw_);
    left_from_rectified_ = rectifier.rectified_from_left().inverse();
    rig_ = vision::characterise(raw_, rectifier.rig(), rectifier.rectified_from_left(), options.resolutions);
    endless_ =
        vision::moved(vision::rig_polytope(rig_.rectified, {}), rectifier.rectified_from_left().inverse());
    plan_tours();
  }

  int run() {
    if (options_.out) {
      make_folder(*options_.out);
      write_meshes();
      write_pictures();
    }
    say();
    if (options_.out) write_json(*options_.out / "report.json", report());
    return kSuccess;
  }

  /// The field and the cameras in another frame, to be shown with those of other rigs.
  NamedField placed(const Eigen::Isometry3d& to_from_left) const {
    const std::string name = fmt::format("{}: {:.3f} m apart, {:g} to {:g} m", raw_.name, raw_.baseline(),
                                         raw_.nearest, raw_.farthest);
    return {name,
            vision::moved(rig_.field, to_from_left * left_from_rectified_),
            {to_from_left.translation(), (to_from_left * raw_.right_from_left.inverse()).translation()}};
  }

 private:
  void plan_tours() {
    using vision::Coverage;
    const hal::HeadLimits& limits = robot_.mission.head;
    const auto plan = [&](const char* what, const vision::FieldAngles& angles, Coverage coverage) {
      CoveredTour tour{what, vision::viewpoints(limits, angles, 0, coverage), {}, {}};
      tour.far_away = vision::covered(endless_, robot_.mission.neck, limits, tour.views, kFarAway);
      tour.at_a_metre = vision::covered(endless_, robot_.mission.neck, limits, tour.views, 1);
      tours_.push_back(std::move(tour));
    };
    const vision::FieldAngles far_away = vision::field_angles(rig_.rectified, kFarAway),
                              near_by = vision::field_angles(rig_.rectified, 1);
    plan("the paper's 33 x 33 deg", {33 * kDegree, 33 * kDegree}, Coverage::kGaze);
    plan("gaze, far away", far_away, Coverage::kGaze);
    if (near_by.horizontal > 0) plan("gaze, at 1 m", near_by, Coverage::kGaze);
    plan("all it can show, far away", far_away, Coverage::kReach);
    if (near_by.horizontal > 0) plan("all it can show, at 1 m", near_by, Coverage::kReach);
  }

  void write_meshes() {
    const auto write = [&](const vision::Polytope& polytope, const std::string& name,
                           const std::string& what) {
      const vision::TriangleMesh mesh = vision::hull_mesh(polytope.corners);
      for (const char* ending : {".ply", ".obj"}) {
        files_.push_back(name + ending);
        write_mesh(mesh, fmt::format("{} of rig {}; {}", what, raw_.name, kFrame),
                   *options_.out / files_.back());
      }
    };
    write(rig_.field, "field", "field");
    for (const auto& resolved : rig_.resolved) {
      const std::string mm = fmt::format("{:g}", resolved.resolution * 1e3);
      write(resolved.polytope, "field_" + mm + "mm", "field seen to " + mm + " mm");
    }
    files_.push_back("points.ply");
    write_points(coloured_points(rig_), fmt::format("pixel pairs of rig {}; {}", raw_.name, kFrame),
                 *options_.out / files_.back());
  }

  void write_pictures() {
    const auto write = [&](const cv::Mat& picture, const char* name) {
      files_.push_back(name);
      write_png(picture, *options_.out / name);
    };
    write(field_picture(rig_), "field.png");
    write(sections_picture(rig_), "sections.png");
    write(resolution_plot(rig_), "resolution.png");
    write(angles_plot(rig_.rectified), "angles.png");
    const auto& views = tours_.front().views;
    const auto caption = [&](const char* where, const vision::CoveredShares& shares) {
      return fmt::format("{} views, {}: {:.0f} % of its gaze", views.size(), where, 100 * shares.gaze);
    };
    write(tours_picture(endless_, robot_.mission.neck, robot_.mission.head,
                        {{views, kFarAway, caption("far away", tours_.front().far_away)},
                         {views, 1, caption("at 1 m", tours_.front().at_a_metre)}}),
          "viewpoints.png");
    if (!options_.pair.empty()) write(reconstructed(), "surface.png");
  }

  cv::Mat reconstructed() const {
    hal::StereoFrame frame;
    frame.left = vision::read_gray(options_.pair[0]);
    frame.right = vision::read_gray(options_.pair[1]);
    vision::StereoVision eyes(raw_);
    const vision::RangeView& view = eyes.see(frame);
    if (!eyes.fault().empty()) throw InputError(options_.pair[0].string() + ": " + eyes.fault());
    return surface_picture(view, eyes.rectified_left());
  }

  /// Depths worth a column: the limits, and round ones between and around them.
  std::vector<double> depths() const {
    std::vector<double> out{raw_.nearest, raw_.farthest};
    for (const double z : {0.5, 1.0, 2.0, 5.0})
      if (std::abs(z - raw_.nearest) > 0.1 * z && std::abs(z - raw_.farthest) > 0.1 * z) out.push_back(z);
    std::sort(out.begin(), out.end());
    out.push_back(kFarAway);
    return out;
  }

  void say() const {
    const vision::RectifiedRig& r = rig_.rectified;
    fmt::print("{}: two cameras of {} x {} px, {:.3f} m apart; rectified focal length {:.1f} px\n\n",
               raw_.name, raw_.left.width, raw_.left.height, raw_.baseline(), r.camera.focal);
    say_field();
    say_sight();
    say_tours();
    if (options_.out)
      fmt::print("\n{}: report.json, {}\n", options_.out->string(), fmt::join(files_, ", "));
    else
      fmt::print("\nWith --out DIR: report.json, pictures, and the field as meshes.\n");
  }

  void say_field() const {
    const auto sizes = [](const char* name, const std::array<vision::PolytopeSize, 3>& s) {
      fmt::print("  {:<34}{:>8}{:>8}{:>8}   {} corners\n", name, s[0].rows, s[1].rows, s[2].rows,
                 s[2].corners);
    };
    fmt::print("The field: half-spaces of the minimal A x >= 0\n  {:<34}{:>8}{:>8}{:>8}\n", "depth limits",
               "none", "near", "both");
    sizes("rectified (what the program sees)", rig_.rectified_sizes);
    sizes("as the cameras are mounted", rig_.mounted_sizes);
    fmt::print(
        "  from {:g} to {:g} m it holds {:.2f} m^3; a matcher that leaves its first {} columns out loses "
        "{:.0f} %\n",
        raw_.nearest, raw_.farthest, vision::volume(rig_.field), rig_.matcher_columns,
        100 * rig_.padded_share);
    fmt::print("The paper's way: {} pixel pairs, {} points between those depths\n", rig_.pairs.pairs,
               rig_.pairs.points.size());
    fmt::print("  {:<34}{:>8}{:>8}\n", "", "here", "paper");
    fmt::print("  {:<34}{:>8}{:>8}\n", "Quickhull: vertices of the hull", rig_.pairs.hull.corners.size(),
               250);
    fmt::print("  {:<34}{:>8}{:>8}\n", "minimal form: half-spaces", rig_.pairs.minimal.rows.size(), 132);
    fmt::print(
        "  (of {} facets; near-parallel ones are merged at 0.2 deg and 5 mm: without that none is "
        "redundant)\n\n",
        rig_.pairs.hull.rows.size());
  }

  void say_sight() const {
    const std::vector<double> at = depths();
    fmt::print("{:<36}", "Depth [m]");
    for (const double z : at) fmt::print("{:>8}", z < kFarAway ? fmt::format("{:g}", z) : "far");
    fmt::print("{:>8}\n  {:<34}", "paper", "field of view, left to right [deg]");
    for (const double z : at)
      fmt::print("{:>8.1f}", vision::field_angles(rig_.rectified, z).horizontal / kDegree);
    fmt::print("{:>8}\n  {:<34}", 33, "field of view, up and down [deg]");
    for (const double z : at)
      fmt::print("{:>8.1f}", vision::field_angles(rig_.rectified, z).vertical / kDegree);
    fmt::print("{:>8}\n  {:<34}", 33, "resolution on the axis [mm]");
    for (const double z : at)
      if (z < kFarAway)
        fmt::print("{:>8.1f}", 1e3 * vision::resolution(rig_.rectified, vision::on_axis(rig_.rectified, z)));
    fmt::print("\n");
    for (const auto& resolved : rig_.resolved)
      fmt::print("  {:<34}{:>8.2f} m, {:.2f} m^3\n",
                 fmt::format("seen to {:g} mm: up to", resolved.resolution * 1e3), resolved.farthest,
                 vision::volume(resolved.polytope));
    fmt::print("\n");
  }

  void say_tours() const {
    const hal::HeadLimits& l = robot_.mission.head;
    fmt::print("Looking around with a head of {:.0f} x {:.0f} deg ({}): share [%] shown\n",
               (l.upper.pan - l.lower.pan) / kDegree, (l.upper.tilt - l.lower.tilt) / kDegree, robot_.name);
    fmt::print("  {:<28}{:>6}{:>16}{:>20}\n", "", "", "of its gaze", "of all it can show");
    fmt::print("  {:<28}{:>6}{:>9}{:>7}{:>13}{:>7}\n", "laid out for", "views", "far", "1 m", "far", "1 m");
    for (const CoveredTour& t : tours_)
      fmt::print("  {:<28}{:>6}{:>9.0f}{:>7.0f}{:>13.0f}{:>7.0f}\n", t.laid_out_for, t.views.size(),
                 100 * t.far_away.gaze, 100 * t.at_a_metre.gaze, 100 * t.far_away.reach,
                 100 * t.at_a_metre.reach);
  }

  Json report() const {
    Json out;
    out["rig"] = {{"name", raw_.name},
                  {"baseline_m", rounded(raw_.baseline())},
                  {"focal_px", rounded(rig_.rectified.camera.focal, 3)},
                  {"near_m", raw_.nearest},
                  {"far_m", raw_.farthest},
                  {"disparity_sigma_px", raw_.disparity_sigma}};
    out["frame"] = kFrame;
    out["field"] = polytope_json(rig_.field);
    out["field"]["volume_m3"] = rounded(vision::volume(rig_.field));
    out["half_spaces"] = {{"rectified", sizes_json(rig_.rectified_sizes)},
                          {"mounted", sizes_json(rig_.mounted_sizes)}};
    out["matcher_without_padding"] = {{"columns", rig_.matcher_columns},
                                      {"field_lost", rounded(rig_.padded_share)}};
    out["pixel_pairs"] = {{"pairs", rig_.pairs.pairs},
                          {"points", rig_.pairs.points.size()},
                          {"hull_vertices", rig_.pairs.hull.corners.size()},
                          {"hull_facets", rig_.pairs.hull.rows.size()},
                          {"minimal_half_spaces", rig_.pairs.minimal.rows.size()},
                          {"verified", vision::is_minimal(rig_.pairs.minimal, 1e-6)},
                          {"paper", {{"hull_vertices", 250}, {"minimal_half_spaces", 132}}}};
    out["field_of_view"] = Json::array();
    for (const double z : depths()) {
      Json entry{{"depth_m", z < kFarAway ? rounded(z) : Json("far")}};
      entry.update(angles_json(vision::field_angles(rig_.rectified, z)));
      out["field_of_view"].push_back(entry);
    }
    out["field_of_view_of_the_paper_deg"] = {33, 33};
    out["resolution"] = Json::array();
    for (const vision::SightAt& s : rig_.sights)
      out["resolution"].push_back({{"depth_m", rounded(s.depth)},
                                   {"on_axis_mm", rounded(s.on_axis * 1e3, 3)},
                                   {"worst_mm", rounded(s.worst * 1e3, 3)},
                                   {"measured_mm", rounded(s.measured * 1e3, 3)}});
    out["fields_for_a_resolution"] = Json::array();
    for (const auto& r : rig_.resolved)
      out["fields_for_a_resolution"].push_back({{"resolution_m", r.resolution},
                                                {"half_spaces", r.polytope.rows.size()},
                                                {"farthest_m", rounded(r.farthest)},
                                                {"volume_m3", rounded(vision::volume(r.polytope))}});
    out["viewpoints"] = Json::array();
    for (const CoveredTour& t : tours_) out["viewpoints"].push_back(tour_json(t));
    out["files"] = files_;
    return out;
  }

  static Json sizes_json(const std::array<vision::PolytopeSize, 3>& sizes) {
    return {{"no_limit", sizes[0].rows},
            {"near", sizes[1].rows},
            {"near_and_far", sizes[2].rows},
            {"corners", sizes[2].corners}};
  }

  static Json tour_json(const CoveredTour& t) {
    return {{"laid_out_for", t.laid_out_for},
            {"views", t.views.size()},
            {"gaze_covered", {{"far", rounded(t.far_away.gaze)}, {"at_1_m", rounded(t.at_a_metre.gaze)}}},
            {"reach_covered", {{"far", rounded(t.far_away.reach)}, {"at_1_m", rounded(t.at_a_metre.reach)}}}};
  }

  CharacteriseOptions options_;
  vision::StereoRig raw_;
  Robot robot_;
  vision::Characteristics rig_;
  Eigen::Isometry3d left_from_rectified_;
  vision::Polytope endless_;  // without depth limits, in the raw left camera's frame
  std::vector<CoveredTour> tours_;
  std::vector<std::string> files_;
};

/// Whether the file describes a head with several rigs (config/hrp2/head.yaml) and not one rig.
bool describes_a_head(const fs::path& path) {
  std::error_code ec;
  return fs::is_regular_file(path, ec) && vision::load_calibration(path).has("rigs");
}

/// Each rig in a folder of its own, and all of them together in one picture.
int characterise_head(const CharacteriseOptions& options) {
  const vision::CameraHead head = vision::read_head(options.rig);
  if (!options.pair.empty())
    throw InputError(options.rig.string() + ": describes several rigs, expected one for --pair");
  if (options.out) make_folder(*options.out);
  std::vector<NamedField> fields;
  for (const vision::HeadRig& rig : head.rigs) {
    CharacteriseOptions one = options;
    if (one.out) *one.out /= rig.rig.name;
    Characterisation characterisation(one, rig.rig, rig.head_from_left);
    characterisation.run();
    fields.push_back(characterisation.placed(rig.head_from_left));
    fmt::print("\n");
  }
  if (!options.out) return kSuccess;
  write_png(fields_picture(fields), *options.out / "head.png");
  fmt::print("{}: head.png, the fields of {} rigs together\n", options.out->string(), fields.size());
  return kSuccess;
}

int characterise(const CharacteriseOptions& options) {
  if (describes_a_head(options.rig)) return characterise_head(options);
  return Characterisation(options, vision::read_rig(options.rig)).run();
}

}  // namespace

void add_characterise(CLI::App& app, Run& run) {
  auto options = std::make_shared<CharacteriseOptions>();
  CLI::App* command = app.add_subcommand("characterise", "Tells what a rig can see, and how precisely.");
  command->footer(
      "Prints the field of view, the resolution over depth, the half-spaces A x >= 0 of the field and the\n"
      "viewpoints that cover what the head can look at. With --out, writes report.json, the field (and that "
      "of\n"
      "each resolution) as PLY and OBJ meshes, points.ply, and field.png, sections.png, resolution.png,\n"
      "angles.png, viewpoints.png; with --pair also surface.png, the pair's surface and its uncertainty.\n"
      "  headway characterise config/hrp2/rigs/bottom.yaml --out build/rig\n"
      "A head with several rigs gets a folder for each, and head.png with their fields together.");
  command->add_option("rig", options->rig, "Rig, or a head with several (config/hrp2/head.yaml)")
      ->required()
      ->type_name("RIG");
  command->add_option("--out", options->out, "Folder for what is written; made if need be")->type_name("DIR");
  command
      ->add_option("--resolution", options->resolutions,
                   "Largest standard deviation of the points in a field of its own")
      ->check(finite_in(1e-5, 10))
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--pair", options->pair, "A stereo pair that this rig took")
      ->expected(2)
      ->type_name("LEFT RIGHT");
  command->add_option("--robot", options->robot, "Robot file: how far the head turns")
      ->type_name("FILE")
      ->capture_default_str();
  command->get_option("--pair")->needs("--out");
  command->callback([options, &run] { run = [options] { return characterise(*options); }; });
}

}  // namespace headway::app
