// The program's commands, one file each. A command declares its options on a CLI11 subcommand and sets the
// function to run; that function returns the exit code.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace headway::app {

/// What the program's exit code says.
enum ExitCode : int {
  kSuccess = 0,     ///< did what was asked
  kNotReached = 1,  ///< ran to its end, but the aim was not reached (no way, collision, fall, poor result)
  kBadInput = 2,    ///< an argument or a file is wrong; one line on stderr says which and how to mend it
  kInternal = 3,    ///< a fault of the program or the machine
};

using Run = std::function<int()>;

void add_sim(CLI::App& app, Run& run);
void add_campaign(CLI::App& app, Run& run);
void add_map(CLI::App& app, Run& run);
void add_plan(CLI::App& app, Run& run);
void add_next_view(CLI::App& app, Run& run);
void add_reconstruct(CLI::App& app, Run& run);
void add_characterise(CLI::App& app, Run& run);
void add_calibrate(CLI::App& app, Run& run);
void add_rig(CLI::App& app, Run& run);
void add_patrol(CLI::App& app, Run& run);
void add_run(CLI::App& app, Run& run);
void add_status(CLI::App& app, Run& run);
void add_go(CLI::App& app, Run& run);
void add_stay(CLI::App& app, Run& run);
void add_reset(CLI::App& app, Run& run);
void add_doctor(CLI::App& app, Run& run);
void add_node(CLI::App& app, Run& run);
void add_can(CLI::App& app, Run& run);
void add_camera(CLI::App& app, Run& run);
void add_record(CLI::App& app, Run& run);
void add_replay(CLI::App& app, Run& run);

/// Parses, runs and turns errors into exit codes; the body of main().
int run_program(int argc, const char* const* argv);

}  // namespace headway::app
