#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/finite_range.h"
#include "app/live_control.h"
#include "app/local_socket.h"
#include "hal/error.h"

namespace headway::app {

namespace {

struct Where {
  std::string socket;
};

void add_socket(CLI::App& command, Where& where) {
  command.add_option("--socket", where.socket,
                     "Where the running program listens, if not where it does of its own accord");
}

/// Where the one program that runs here listens. Throws InputError where there is none, or more than one.
std::filesystem::path find_running(const Where& where) {
  if (!where.socket.empty()) return where.socket;
  std::vector<std::string> tried, found;
  for (const auto& place : known_sockets()) {
    tried.push_back(place.native());
    if (listens(place)) found.push_back(place.native());
  }
  if (found.empty())
    throw InputError(fmt::format("no 'headway run' listens at {}; --socket names another place",
                                 fmt::join(tried, " or ")));
  if (found.size() > 1)
    throw InputError(
        fmt::format("robots are guided at {}; say which with --socket", fmt::join(found, " and ")));
  return found.front();
}

/// What the program that runs here answers. Throws InputError where it refuses.
Json ask_running(const Where& where, const Json& question) {
  const std::filesystem::path place = find_running(where);
  const Json said = Json::parse(ask(place, question.dump()), nullptr, false);
  if (!said.is_object() || !said.contains("ok"))
    throw Error(fmt::format("{}: its answer is not understood; is it of another release?", place.native()));
  if (said.at("ok") == true) return said;
  throw InputError(said.value("error", "refused without a reason"));
}

struct Status : Where {
  bool json = false, metrics = false;
};

int status(const Status& options) {
  const Json said = ask_running(options, {{"do", "status"}});
  fmt::print("{}", options.json      ? said.dump(2) + "\n"
                   : options.metrics ? status_metrics(said)
                                     : status_text(said));
  return kSuccess;
}

struct Go : Where {
  std::vector<double> to;
  bool map = false, near = false;
};

int go(const Go& options) {
  Json question{{"do", "go"},
                {"to", {options.to[0], options.to[1]}},
                {"from", options.map ? "map" : "robot"},
                {"near", options.near}};
  if (options.to.size() == 3) question["yaw_deg"] = options.to[2];
  const Json said = ask_running(options, question);
  fmt::print("goes to ({:.2f}, {:.2f}) in the map; 'headway status' tells how far it is\n",
             said.at("x").get<double>(), said.at("y").get<double>());
  return kSuccess;
}

/// For what needs no more than to be asked for.
int ask_for(const char* what, const Where& options) {
  ask_running(options, {{"do", what}});
  return kSuccess;
}

}  // namespace

void add_status(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Status>();
  CLI::App* command =
      app.add_subcommand("status", "How the robot is that 'headway run' guides on this machine");
  add_socket(*command, *options);
  command->add_flag("--json", options->json, "For a program");
  command->add_flag("--metrics", options->metrics, "For Prometheus (text exposition format)")
      ->excludes("--json");
  command->callback([options, &run_command] { run_command = [options] { return status(*options); }; });
}

void add_go(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Go>();
  CLI::App* command =
      app.add_subcommand("go", "Send the robot that 'headway run' guides on this machine to a place");
  command
      ->add_option("to", options->to,
                   "Where to [m, deg], as seen from where it stands: ahead, to the left, turned to the left")
      ->required()
      ->delimiter(',')
      ->expected(2, 3)
      ->option_text("X,Y[,YAW]")
      ->check(finite_in(-500, 500));
  command->add_flag("--map", options->map, "The numbers are coordinates of the map");
  command->add_flag("--near", options->near, "Where no way leads there, as near as it gets will do");
  add_socket(*command, *options);
  command->footer(
      "Example: headway go 2,0.5\nIt walks at once when it has looked around; 'headway stay' brings it to "
      "rest.");
  command->callback([options, &run_command] { run_command = [options] { return go(*options); }; });
}

void add_stay(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Where>();
  CLI::App* command = app.add_subcommand(
      "stay", "Bring the robot that 'headway run' guides on this machine to rest; its goal is given up");
  add_socket(*command, *options);
  command->footer("This is no emergency stop: that is the button that is wired to the motors' power.");
  command->callback(
      [options, &run_command] { run_command = [options] { return ask_for("stay", *options); }; });
}

void add_reset(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Where>();
  CLI::App* command = app.add_subcommand(
      "reset", "After a fault of the control computer or a drive: somebody has looked at it");
  add_socket(*command, *options);
  command->footer("It stays at rest until 'headway go' comes after it.");
  command->callback(
      [options, &run_command] { run_command = [options] { return ask_for("reset", *options); }; });
}

}  // namespace headway::app
