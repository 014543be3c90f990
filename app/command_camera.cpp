// headway camera list, and headway camera show: which cameras there are, and what one or two of them see.
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "app/camera_look.h"
#include "app/commands.h"
#include "app/finite_range.h"
#include "app/output_folder.h"
#include "app/pictures.h"
#include "drivers/v4l2_listing.h"
#include "hal/error.h"

namespace headway::app {

namespace {

namespace fs = std::filesystem;

struct ShowOptions {
  std::string device, right;  ///< the only camera, or the left eye; the right eye, if any
  std::optional<fs::path> out;
  std::vector<int> size{640, 480};  ///< width, height [px]
  std::string format = "YUYV";
  std::optional<double> rate, exposure_ms;
  std::optional<int> gain, white_balance;
  double seconds = 3;
};

drivers::V4l2CameraConfig config_of(const ShowOptions& options, const std::string& device) {
  drivers::V4l2CameraConfig config;
  config.path = device;
  config.width = options.size[0];
  config.height = options.size[1];
  config.format = *drivers::image_format_named(options.format);
  config.rate = options.rate;
  if (options.exposure_ms) config.exposure = seconds(*options.exposure_ms * 1e-3);
  config.gain = options.gain;
  config.white_balance = options.white_balance;
  return config;
}

CameraLook look(const ShowOptions& options) {
  hal::MonotonicClock clock;
  const Duration time = seconds(options.seconds);
  const drivers::V4l2CameraConfig first = config_of(options, options.device);
  if (options.right.empty()) return look_through(first, time, clock, drivers::kernel_calls());
  const drivers::StereoPairConfig pair{first, config_of(options, options.right), std::nullopt};
  return look_through(pair, time, clock, drivers::kernel_calls());
}

void write(const CameraLook& look, const fs::path& folder) {
  OutputFolder out(folder, "camera show");
  for (const EyeLook& eye : look.eyes) {
    if (!eye.image.pixels.empty()) write_png(image_picture(eye.image), out.file(eye.name + ".png"));
  }
  out.report(json_of(look));
  fmt::print("{}\n", out.list());
}

int show(const ShowOptions& options) {
  const CameraLook seen = look(options);
  fmt::print("{}", text_of(seen));
  for (const EyeLook& eye : seen.eyes)
    fmt::print("{} offers {}\n", eye.name,
               drivers::one_line(drivers::offered_formats(drivers::kernel_calls(), eye.path.c_str())));
  if (options.out) write(seen, *options.out);
  return seen.is_well() ? kSuccess : kNotReached;
}

int list() {
  const std::vector<drivers::ListedCamera> cameras = drivers::list_cameras(drivers::kernel_calls(), "/dev");
  if (cameras.empty())
    fmt::print("no camera that this user may open; is one plugged in{}?\n",
               geteuid() == 0 ? ", and its driver loaded" : ", and is the user in the group video");
  for (const drivers::ListedCamera& camera : cameras) {
    fmt::print("{}: {} ({})\n", camera.path, camera.name, camera.bus);
    if (!camera.port_path.empty()) fmt::print("  {}\n", camera.port_path);
    fmt::print("  offers {}\n",
               drivers::one_line(drivers::offered_formats(drivers::kernel_calls(), camera.path.c_str())));
  }
  return kSuccess;
}

void add_show(CLI::App& camera, Run& run) {
  auto options = std::make_shared<ShowOptions>();
  CLI::App* command =
      camera.add_subcommand("show", "Looks through one camera, or a pair, and says how well that works.");
  command->footer(
      "  headway camera show /dev/video0 --out look                                one camera\n"
      "  headway camera show /dev/v4l/by-path/A /dev/v4l/by-path/B --exposure 8    left and right eye\n"
      "By-path names stay with the port, so they say which eye it is. Exits with 1 when a camera shows "
      "nothing\n"
      "usable, or two are not exposed at the same time.");
  command->add_option("device", options->device, "The camera, or the left eye")
      ->required()
      ->type_name("DEVICE");
  command->add_option("right", options->right, "The right eye")->type_name("DEVICE");
  command->add_option("--out", options->out, kOutHelp)->type_name("DIR");
  command->add_option("--size", options->size, "Size of the images")
      ->delimiter('x')
      ->expected(2)
      ->check(CLI::Range(1, 16384))
      ->option_text("WIDTHxHEIGHT")
      ->capture_default_str();
  command->add_option("--format", options->format, "How pixels are sent")
      ->transform(CLI::IsMember(drivers::image_format_names(), CLI::ignore_case))
      ->type_name("NAME")
      ->capture_default_str();
  command->add_option("--rate", options->rate, "Frames per second; the camera's own unless given")
      ->check(finite_in(0.1, 1000))
      ->type_name("HZ");
  command->add_option("--exposure", options->exposure_ms, "Exposure; automatic unless given")
      ->check(finite_in(0.1, 10000))
      ->type_name("MS");
  command->add_option("--gain", options->gain, "Gain in the camera's units; automatic unless given")
      ->check(CLI::Range(0, 1000000))
      ->type_name("N");
  command->add_option("--white-balance", options->white_balance, "Colour temperature; automatic unless given")
      ->check(CLI::Range(1, 100000))
      ->type_name("K");
  command->add_option("--seconds", options->seconds, "How long to look")
      ->check(finite_in(0.5, 3600))
      ->type_name("S")
      ->capture_default_str();
  command->callback([options, &run] { run = [options] { return show(*options); }; });
}

}  // namespace

void add_camera(CLI::App& app, Run& run) {
  CLI::App* camera = app.add_subcommand("camera", "Lists cameras (V4L2), or looks through them.");
  camera->require_subcommand(1);
  add_show(*camera, run);
  camera->add_subcommand("list", "Lists cameras and the formats they offer.")->callback([&run] {
    run = list;
  });
}

}  // namespace headway::app
