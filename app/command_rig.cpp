// headway rig convert: a calibration of one tool for another.
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/finite_range.h"
#include "hal/error.h"
#include "vision/rig_files.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

struct ConvertOptions {
  std::string from, to;
  std::optional<std::string> name;
  std::optional<double> near, far, sigma;
  std::vector<int> size;  ///< width, height [px]
};

/// Throws InputError where one file would be both cameras'.
void require_two_files(const std::string& left, const std::string& right) {
  std::error_code ignored;
  if (fs::weakly_canonical(left, ignored) == fs::weakly_canonical(right, ignored))
    throw InputError(fmt::format("{0},{1}: is one file for both cameras, expected two", left, right));
}

/// --size is for calibrations that do not say it: on another it would do nothing.
vision::StereoRig read(const ConvertOptions& options) {
  if (!options.size.empty()) {
    std::optional<vision::StereoRig> sized;
    try {
      sized = vision::read_rig(options.from);
    } catch (const InputError&) {
      // With the size it may do.
    }
    if (sized)
      throw InputError(
          fmt::format("rig convert: --size is for calibrations that do not say it, but {} says "
                      "{} x {} px; leave it out",
                      options.from, sized->left.width, sized->left.height));
  }
  vision::RigDefaults defaults;
  if (!options.size.empty()) defaults.width = options.size[0], defaults.height = options.size[1];
  return vision::read_rig(options.from, defaults);
}

/// A calibration that gives its rig no name has that of its file, for messages: then the new file's is it.
std::string name_of(const vision::StereoRig& rig, const ConvertOptions& options) {
  const bool is_path = options.from == rig.name || options.from.starts_with(rig.name + ",");
  return is_path ? fs::path(options.to.substr(0, options.to.find(','))).stem().string() : rig.name;
}

int convert(const ConvertOptions& options) {
  const std::size_t comma = options.to.find(',');
  if (comma != std::string::npos)
    require_two_files(options.to.substr(0, comma), options.to.substr(comma + 1));
  vision::StereoRig rig = read(options);
  rig.name = options.name.value_or(name_of(rig, options));
  rig.nearest = options.near.value_or(rig.nearest);
  rig.farthest = options.far.value_or(rig.farthest);
  rig.disparity_sigma = options.sigma.value_or(rig.disparity_sigma);
  vision::require_usable(rig);
  if (comma == std::string::npos)
    vision::write_rig(rig, options.to);
  else
    vision::write_camera_info(rig, options.to.substr(0, comma), options.to.substr(comma + 1));
  fmt::print("{}: two cameras of {} x {} px, {:.4f} m apart, written as {}\n", options.to, rig.left.width,
             rig.left.height, rig.baseline(),
             comma == std::string::npos ? "a rig of ours"
                                        : "ROS camera_info, which has no key for depth limits and sigma");
  return kSuccess;
}

}  // namespace

void add_rig(CLI::App& app, Run& run) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* rig = app.add_subcommand("rig", "Turns a rig's calibration into another tool's form.");
  rig->require_subcommand(1);
  CLI::App* command = rig->add_subcommand("convert", "Reads a calibration and writes it in another form.");
  command->footer(
      "FROM is what --rig takes: our YAML, Kalibr's camchain, OpenCV's yml, two files with a comma between\n"
      "them (ROS camera_info, EuRoC's sensor.yaml, OpenCV's intrinsics and extrinsics), or a folder with "
      "them.\n"
      "  headway rig convert camchain.yaml rig.yaml             our own form\n"
      "  headway rig convert rig.yaml left.yaml,right.yaml      ROS camera_info of both cameras\n"
      "Our own form also says for which depths a rig is used and how far its matches are off.");
  command->add_option("from", options->from, "The calibration that is there")->required()->type_name("FROM");
  command->add_option("to", options->to, "One file: ours; LEFT,RIGHT: ROS camera_info")
      ->required()
      ->type_name("TO");
  command->add_option("--name", options->name, "The rig's name; as it was unless given")->type_name("NAME");
  const auto depth = [&](const char* option, auto& value, const char* help) {
    command->add_option(option, value, help)->check(finite_in(0.05, 1000))->type_name("M");
  };
  depth("--near", options->near, "Nearest depth it is used for; as it was, or 0.8");
  depth("--far", options->far, "Farthest depth it is used for; as it was, or 8");
  command->add_option("--sigma", options->sigma, "Standard deviation of its matches; as it was, or 0.25")
      ->check(finite_in(0.01, 10))
      ->type_name("PX");
  command
      ->add_option("--size", options->size,
                   "Size of the images, where the calibration does not say it (OpenCV's)")
      ->expected(2)
      ->check(CLI::Range(1, 100000))
      ->type_name("WIDTH HEIGHT");
  command->callback([options, &run] { run = [options] { return convert(*options); }; });
}

}  // namespace headway::app
