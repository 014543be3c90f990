#include <exception>
#include <new>

#include <fmt/format.h>
#include <opencv2/core/utility.hpp>

#include "app/argument_fault.h"
#include "app/commands.h"
#include "app/standard_streams.h"
#include "hal/error.h"

namespace headway::app {

namespace {

/// Runs the command that was chosen, or shows help; what it said must have arrived.
int run_chosen(CLI::App& program, const Run& run, int argc, const char* const* argv) {
  int code = kSuccess;
  try {
    program.parse(argc, argv);
    code = run();
  } catch (const CLI::ParseError& fault) {
    if (fault.get_exit_code() != 0) throw InputError(argument_fault(program, fault));
    program.exit(fault);
  }
  flush_output();
  return code;
}

}  // namespace

int run_program(int argc, const char* const* argv) {
  CLI::App program{
      "Headway: eyes, map and feet of a humanoid robot.\n"
      "Turns stereo images into a map of what is occupied, empty and unseen, plans a way and walks it."};
  program.name("headway");
  program.require_subcommand(1);
  program.set_version_flag("--version", "headway 0.1.0");
  program.footer(
      "A command first removes from --out what its own earlier run left there (as report.json lists it), and "
      "refuses\n"
      "a folder with another command's report.json.\n"
      "Exit codes: 0 done; 1 ran, but the aim was not reached; 2 bad input (one line says what to mend);\n"
      "3 fault of the program or machine. 'headway COMMAND --help' explains a command.");
  // One core: the frame loop's work stays in its own thread.
  cv::setNumThreads(1);
  Run run;
  add_sim(program, run);
  add_campaign(program, run);
  add_map(program, run);
  add_plan(program, run);
  add_next_view(program, run);
  add_reconstruct(program, run);
  add_characterise(program, run);
  add_calibrate(program, run);
  add_rig(program, run);
  add_patrol(program, run);
  add_run(program, run);
  add_status(program, run);
  add_go(program, run);
  add_stay(program, run);
  add_reset(program, run);
  add_doctor(program, run);
  add_node(program, run);
  add_can(program, run);
  add_camera(program, run);
  add_record(program, run);
  add_replay(program, run);
  try {
    return run_chosen(program, run, argc, argv);
  } catch (const InputError& e) {
    say_error("headway: {}\n", e.what());
    return kBadInput;
  } catch (const std::bad_alloc&) {
    say_error(
        "headway: there is not enough memory; coarser voxels, smaller images or a shorter range need less\n");
    return kInternal;
  } catch (const std::exception& e) {
    say_error("headway: {}\n", e.what());
    return kInternal;
  }
}

}  // namespace headway::app
