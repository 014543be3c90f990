#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core/utility.hpp>

#include "app/commands.h"
#include "config/spelling.h"
#include "config/yaml_limits.h"
#include "hal/error.h"

namespace headway::app {

namespace {

/// The first argument that looks like an option and is none, and which one may be meant; empty: there is
/// none. It is told before what is missing, which is mostly what it was to be.
std::string unknown_option(const CLI::App& program, const CLI::App& command) {
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (const std::string& argument : program.remaining(true)) {
    if (!argument.starts_with("--") || argument == "--") continue;
    const std::string name = argument.substr(0, argument.find('='));
    const std::string meant = config::meant_by(name, known);
    return fmt::format("{} is no option{}", config::one_line(name),
                       meant.empty() ? "" : fmt::format("; did you mean {}?", meant));
  }
  return "";
}

/// What is wrong with the arguments, and where to read on, in one line.
std::string told(const CLI::App& program, const CLI::ParseError& fault) {
  std::string chosen;
  const CLI::App* last = &program;
  while (!last->get_subcommands().empty()) {
    last = last->get_subcommands().front();
    chosen += (chosen.empty() ? "" : " ") + last->get_name();
  }
  if (last->get_require_subcommand_min() == 0) {
    const std::string stranger = unknown_option(program, *last);
    return fmt::format("{0}: {1}; see 'headway {0} --help'", chosen,
                       stranger.empty() ? config::one_line(fault.what()) : stranger);
  }
  std::vector<std::string> commands;
  for (const CLI::App* command : last->get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(command->get_name());
  const std::vector<std::string> rest = program.remaining(true);
  const std::string what =
      rest.empty() ? "no command" : fmt::format("'{}' is no command", config::one_line(rest.front()));
  return fmt::format("{}{}, expected one of: {}; see 'headway {}--help'", chosen.empty() ? "" : chosen + ": ",
                     what, fmt::join(commands, ", "), chosen.empty() ? "" : chosen + " ");
}

/// Runs the command that was chosen, or shows help; what it said must have arrived.
int run_chosen(CLI::App& program, const Run& run, int argc, const char* const* argv) {
  int code = kSuccess;
  try {
    program.parse(argc, argv);
    code = run();
  } catch (const CLI::ParseError& fault) {
    if (fault.get_exit_code() != 0) throw InputError(told(program, fault));
    program.exit(fault);
  }
  errno = 0;
  if (!std::cout.flush() || std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw Error(fmt::format("standard output cannot be written ({})",
                            errno ? std::strerror(errno) : "an earlier fault"));
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
  add_run(program, run);
  add_doctor(program, run);
  add_node(program, run);
  add_can(program, run);
  add_camera(program, run);
  add_record(program, run);
  add_replay(program, run);
  try {
    return run_chosen(program, run, argc, argv);
  } catch (const InputError& e) {
    fmt::print(stderr, "headway: {}\n", e.what());
    return kBadInput;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr,
               "headway: there is not enough memory; coarser voxels, smaller images or a shorter "
               "range need less\n");
    return kInternal;
  } catch (const std::exception& e) {
    fmt::print(stderr, "headway: {}\n", e.what());
    return kInternal;
  }
}

}  // namespace headway::app
