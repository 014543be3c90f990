// headway characterise: what a rig can see, and how precisely, before it has seen anything.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/characterisation.h"
#include "app/characterisation_report.h"
#include "app/characterisation_text.h"
#include "app/commands.h"
#include "app/drawing.h"
#include "app/field_pictures.h"
#include "app/finite_range.h"
#include "app/mesh_files.h"
#include "app/output_folder.h"
#include "app/report.h"
#include "app/rig_plots.h"
#include "app/sight_report.h"
#include "app/surface_picture.h"
#include "app/tour_picture.h"
#include "hal/error.h"
#include "vision/calibration_file.h"
#include "vision/head_file.h"
#include "vision/image_files.h"
#include "vision/rig_files.h"
#include "vision/stereo.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

struct CharacteriseOptions {
  fs::path rig, robot = default_robot_file();
  fs::path out;  ///< empty: nothing is written
  std::vector<double> resolutions{0.005, 0.02, 0.05};
  std::vector<fs::path> pair;
};

/// What the rig sees in the pair that it took.
struct SeenPair {
  SeenPair(const vision::StereoRig& rig, const fs::path& left, const fs::path& right)
      : eyes(rig), view(see(left, right)) {}

  vision::StereoVision eyes;
  const vision::RangeView& view;  ///< of the eyes

 private:
  const vision::RangeView& see(const fs::path& left, const fs::path& right) {
    hal::StereoFrame frame;
    frame.left = vision::read_gray(left);
    frame.right = vision::read_gray(right);
    require_two_images(frame, left, right);
    const vision::RangeView& seen = eyes.see(frame);
    if (!eyes.fault().empty()) throw InputError(left.string() + ": " + eyes.fault());
    return seen;
  }
};

/// The files of one rig, in a folder.
class CharacterisationFiles {
 public:
  CharacterisationFiles(const Characterisation& characterisation, OutputFolder& folder)
      : c_(characterisation), folder_(folder) {}

  void write_meshes() {
    write_mesh_of(c_.rig.field, "field", "field");
    for (const auto& resolved : c_.rig.resolved) {
      const std::string mm = fmt::format("{:g}", resolved.resolution * 1e3);
      write_mesh_of(resolved.polytope, "field_" + mm + "mm", "field seen to " + mm + " mm");
    }
    write_points(coloured_points(c_.rig),
                 fmt::format("pixel pairs of rig {}; {}", c_.raw.name, kCharacterisedFrame),
                 folder_.file("points.ply"));
  }

  void write_pictures() {
    write_png(field_picture(c_.rig), folder_.file("field.png"));
    write_png(sections_picture(c_.rig), folder_.file("sections.png"));
    write_png(resolution_plot(c_.rig), folder_.file("resolution.png"));
    write_png(angles_plot(c_.rig.rectified), folder_.file("angles.png"));
    const CoveredTour& tour = c_.tours.front();
    const auto caption = [&](const char* where, const vision::CoveredShares& shares) {
      return fmt::format("{} views, {}: {:.0f} % of its gaze", tour.views.size(), where, 100 * shares.gaze);
    };
    write_png(tours_picture(c_.endless, c_.robot.mission.neck, c_.robot.mission.head,
                            {{tour.views, kFarAway, caption("far away", tour.far_away)},
                             {tour.views, 1, caption("at 1 m", tour.at_a_metre)}}),
              folder_.file("viewpoints.png"));
  }

  void write_surface(const SeenPair& pair) {
    write_png(surface_picture(pair.view, pair.eyes.rectified_left()), folder_.file("surface.png"));
  }

 private:
  void write_mesh_of(const vision::Polytope& polytope, const std::string& name, const std::string& what) {
    const vision::TriangleMesh mesh = vision::hull_mesh(polytope.corners);
    for (const char* ending : {".ply", ".obj"})
      write_mesh(mesh, fmt::format("{} of rig {}; {}", what, c_.raw.name, kCharacterisedFrame),
                 folder_.file(name + ending));
  }

  const Characterisation& c_;
  OutputFolder& folder_;
};

std::optional<OutputFolder> folder_of(const CharacteriseOptions& options) {
  if (options.out.empty()) return std::nullopt;
  return OutputFolder(options.out, "characterise");
}

/// Prints and writes all of one rig. The aim is missed where the pair shows that the cameras do not see well.
/// Without a folder nothing is written.
int tell(const Characterisation& c, const CharacteriseOptions& options, OutputFolder* out,
         const SeenPair* pair = nullptr) {
  print_characterisation(c);
  if (!out) {
    fmt::print("\nWith --out DIR: report.json, pictures, and the field as meshes.\n");
    return kSuccess;
  }
  CharacterisationFiles files(c, *out);
  files.write_meshes();
  files.write_pictures();
  Json report = characterisation_report(c);
  if (pair) {
    files.write_surface(*pair);
    report["sight"] = sight_report(pair->eyes.sight());
  }
  out->report(report);
  fmt::print("\n{}\n", out->list());
  if (!pair) return kSuccess;
  print_findings(pair->eyes.sight(), options.pair[0], options.pair[1]);
  return pair->eyes.sight().fault() ? kNotReached : kSuccess;
}

/// The field and the cameras in another frame, to be shown with those of other rigs.
NamedField placed(const Characterisation& c, const Eigen::Isometry3d& to_from_left) {
  const std::string name = fmt::format("{}: {:.3f} m apart, {:g} to {:g} m", c.raw.name, c.raw.baseline(),
                                       c.raw.nearest, c.raw.farthest);
  return {name,
          vision::moved(c.rig.field, to_from_left * c.left_from_rectified),
          {to_from_left.translation(), (to_from_left * c.raw.right_from_left.inverse()).translation()}};
}

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
  std::optional<OutputFolder> out = folder_of(options);
  std::vector<NamedField> fields;
  Json names = Json::array();
  for (const vision::HeadRig& rig : head.rigs) {
    const Characterisation c = characterised(rig.rig, options.robot, options.resolutions, rig.head_from_left);
    std::optional<OutputFolder> below;
    if (out) below.emplace(out->below(rig.rig.name));
    tell(c, options, below ? &*below : nullptr);
    fields.push_back(placed(c, rig.head_from_left));
    names.push_back(rig.rig.name);
    fmt::print("\n");
  }
  if (!out) return kSuccess;
  write_png(fields_picture(fields), out->file("head.png"));
  out->report({{"rigs", names}});
  fmt::print("{}; the fields of {} rigs together are in head.png\n", out->list(), fields.size());
  return kSuccess;
}

int characterise(const CharacteriseOptions& options) {
  if (describes_a_head(options.rig)) return characterise_head(options);
  const Characterisation c = characterised(vision::read_rig(options.rig), options.robot, options.resolutions);
  std::optional<SeenPair> pair;
  if (!options.pair.empty()) pair.emplace(c.raw, options.pair[0], options.pair[1]);
  std::optional<OutputFolder> out = folder_of(options);
  return tell(c, options, out ? &*out : nullptr, pair ? &*pair : nullptr);
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
      "'Paper' marks the figures of the 2006 HRP-2 work that this follows.\n"
      "A head with several rigs gets a folder for each, and head.png with their fields together.");
  command->add_option("rig", options->rig, "Rig, or a head with several (config/hrp2/head.yaml)")
      ->required()
      ->type_name("RIG");
  command->add_option("--out", options->out, kOutHelp)->type_name("DIR");
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
