#include <cstdio>
#include <exception>

#include <fmt/format.h>
#include <opencv2/core/utility.hpp>

#include "app/commands.h"
#include "hal/error.h"

namespace headway::app {

int run_program(int argc, const char* const* argv) {
  CLI::App program{
      "Headway: eyes, map and feet of a humanoid robot.\n"
      "Turns stereo images into a map of what is occupied, empty and unseen, plans a way and walks it."};
  program.name("headway");
  program.require_subcommand(1);
  program.set_version_flag("--version", "headway 0.1.0");
  program.footer(
      "Exit codes: 0 done; 1 ran, but the aim was not reached; 2 bad input (one line says what to mend);\n"
      "3 fault of the program or machine. 'headway COMMAND --help' explains a command.");
  // One core: the frame loop's work stays in its own thread.
  cv::setNumThreads(1);
  Run run;
  add_sim(program, run);
  add_campaign(program, run);
  add_map(program, run);
  add_reconstruct(program, run);
  add_characterise(program, run);
  add_calibrate(program, run);
  add_rig(program, run);
  try {
    program.parse(argc, argv);
    return run();
  } catch (const CLI::ParseError& e) {
    const int code = program.exit(e);
    return code == 0 ? kSuccess : kBadInput;
  } catch (const InputError& e) {
    fmt::print(stderr, "headway: {}\n", e.what());
    return kBadInput;
  } catch (const std::exception& e) {
    fmt::print(stderr, "headway: {}\n", e.what());
    return kInternal;
  }
}

}  // namespace headway::app
