// headway calibrate: images of a board in; a rig out, or where its camera sits on the neck.
#include <charconv>
#include <memory>

#include <fmt/format.h>

#include "app/calibrate_head.h"
#include "app/calibrate_rig.h"
#include "app/commands.h"
#include "app/finite_range.h"
#include "app/output_folder.h"
#include "app/robot_file.h"
#include "hal/error.h"

namespace headway::app {

namespace {

struct CalibrateOptions {
  RigCalibrationOptions rig;
  std::string board, charuco;
  double square = 0, marker = 0;
  bool alike = false, head = false;
  std::string head_rig, robot = default_robot_file().string();
  std::vector<double> corner;
  double corner_sigma = 0.002;
};

int number_of(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : -1;
}

vision::Board board_of(const CalibrateOptions& options) {
  vision::Board board;
  const std::size_t by = options.board.find('x');
  board.columns = number_of(std::string_view(options.board).substr(0, by));
  board.rows = by == std::string::npos ? -1 : number_of(std::string_view(options.board).substr(by + 1));
  if (board.columns < 0 || board.rows < 0) {
    throw InputError(
        fmt::format("--board '{}': expected inner corners across x down, as 9x6", options.board));
  }
  board.square = options.square;
  if (!options.charuco.empty()) board.markers = vision::BoardMarkers{options.charuco, options.marker};
  vision::require_usable(board);
  return board;
}

int calibrate_head(const CalibrateOptions& options) {
  HeadCalibrationOptions head;
  if (options.rig.paths.size() != 1)
    throw InputError("calibrate --head: expected one folder with images and head.csv");
  if (options.head_rig.empty())
    throw InputError("calibrate --head: no calibration of the camera, expected --rig FILE");
  head.folder = options.rig.paths.front();
  head.rig = options.head_rig, head.robot = options.robot, head.out = options.rig.out;
  head.board = board_of(options);
  if (!options.corner.empty()) {
    head.corner = vision::MeasuredCorner{Eigen::Map<const Eigen::Vector3d>(options.corner.data()),
                                         options.corner_sigma};
  }
  return calibrate_head_of(head);
}

int calibrate(CalibrateOptions options) {
  if (options.head) return calibrate_head(options);
  options.rig.board = board_of(options);
  options.rig.lenses = options.alike ? vision::Lenses::kAlike : vision::Lenses::kEach;
  return calibrate_rig(options.rig);
}

}  // namespace

void add_calibrate(CLI::App& app, Run& run) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = app.add_subcommand("calibrate", "Turns images of a board into a rig file.");
  command->footer(
      "Show the board to both cameras at once, 10 times or more: near and far, in every corner of the "
      "images,\n"
      "turned to all sides by 20 deg and more. The images are\n"
      "  a folder with left*.png and right*.png (or folders left and right, or cam0/data and cam1/data),\n"
      "  two folders, two patterns in quotes ('l/*.png' 'r/*.png'), or files left... and right....\n"
      "Writes rig.yaml, report.json (errors per pair; every number with its standard deviation) and\n"
      "coverage.png. The epipolar error is the distance of the rows of one corner in the rectified images.\n"
      "A pair stands out when its reprojection or epipolar error exceeds the median of all pairs by more\n"
      "than 4 robust standard deviations (1.4826 times the median deviation) and by a quarter.\n"
      "Exit code 1: the mean epipolar error is above 0.5 px; matching would suffer.\n"
      "\n"
      "With --head the folder holds the left camera's images, named by their stamp in nanoseconds, and "
      "head.csv:\n"
      "stamp [ns], pan [deg], tilt [deg] a line, as the drives report them, every 20 ms or so. Let the head "
      "move\n"
      "to all sides, the board still and in view, and take images while it moves. Writes neck.yaml (for the "
      "robot\n"
      "file), report.json and views.png. Found are the camera's place and its turns about the tilt link's x "
      "and z\n"
      "axes, the tilt zero, and the time to add to the camera's stamps. A turn about the tilt axis itself "
      "cannot be\n"
      "told from the tilt zero, and counts as that. The pan zero cannot be told from the board's unknown "
      "place: it is\n"
      "found only with --corner, where a corner of the board is measured in the chest's frame. That is\n"
      "corner 0: of a board with markers the upper left one as printed; of a chessboard the one beside the "
      "dark\n"
      "inner square if its sides are odd and even (9x6), else the upper left one as seen.\n"
      "Exit code 1: corners are more than 1 px from where they should be.");
  command->add_option("images", options->rig.paths, "Folder, two folders, two patterns, or images")
      ->required()
      ->type_name("PATH");
  command->add_option("--board", options->board, "Inner corners across x down; 10 x 7 squares have 9x6")
      ->required()
      ->type_name("CxR");
  command->add_option("--square", options->square, "Edge of a square")
      ->required()
      ->check(finite_in(0.001, 1))
      ->type_name("M");
  CLI::Option* charuco =
      command->add_option("--charuco", options->charuco, "Markers in the white squares, as 4X4_50 or 5X5_100")
          ->type_name("DICT");
  CLI::Option* marker = command->add_option("--marker", options->marker, "Edge of a marker")
                            ->check(finite_in(0.0001, 1))
                            ->type_name("M")
                            ->needs(charuco);
  charuco->needs(marker);
  command->add_option("--out", options->rig.out, kOutHelp)->required()->type_name("DIR");
  command->add_flag("--alike", options->alike,
                    "Take both lenses to have one focal length and no tangential distortion: for few pairs");
  command->add_option("--name", options->rig.name, "Name of the rig")
      ->type_name("NAME")
      ->capture_default_str();
  command->add_option("--near", options->rig.nearest, "Nearest depth that must be matched, for the rig file")
      ->check(finite_in(0.05, 100))
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--far", options->rig.farthest, "Farthest depth that goes into the map")
      ->check(finite_in(0.05, 1000))
      ->type_name("M")
      ->capture_default_str();
  CLI::Option* head = command->add_flag(
      "--head", options->head,
      "Find where the camera sits on the neck: one board that stands still, seen while the head moves");
  for (const char* of_a_rig : {"--alike", "--name", "--near", "--far"}) head->excludes(of_a_rig);
  command->add_option("--rig", options->head_rig, "Rig file; its left camera took the images")
      ->needs(head)
      ->type_name("FILE");
  command->add_option("--robot", options->robot, "Robot file: the neck as designed")
      ->needs(head)
      ->type_name("FILE")
      ->capture_default_str();
  CLI::Option* corner =
      command->add_option("--corner", options->corner, "Corner 0 of the board in the chest's frame, measured")
          ->check(finite_in(-10, 10))
          ->needs(head)
          ->delimiter(',')
          ->expected(3)
          ->type_name("X,Y,Z");
  command->add_option("--corner-sigma", options->corner_sigma, "How well each coordinate is measured")
      ->check(finite_in(1e-6, 1))
      ->needs(corner)
      ->type_name("M")
      ->capture_default_str();
  command->callback([options, &run] { run = [options] { return calibrate(*options); }; });
}

}  // namespace headway::app
