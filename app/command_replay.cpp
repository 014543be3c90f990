#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/interrupts.h"
#include "app/output_folder.h"
#include "app/replay_player.h"
#include "app/replay_session.h"
#include "hal/error.h"
#include "nav/cold_map_file.h"
#include "runtime/durable_file.h"

namespace headway::app {

namespace {

struct Options {
  std::filesystem::path file, out;
  ServeOptions page;
};

Json report_of(const Options& options, const ReplaySession& session) {
  const runtime::ReplayResult& result = session.result();
  const auto text = [](const std::optional<std::string>& some) { return some ? Json(*some) : Json(nullptr); };
  return {{"recording", options.file.string()},
          {"robot", session.robot().name},
          {"same", result.same()},
          {"works", result.works},
          {"frames", result.frames},
          {"orders", result.orders},
          {"first_s", to_seconds(result.first)},
          {"last_s", to_seconds(result.last)},
          {"difference", text(result.difference)},
          {"missing", text(result.missing)}};
}

void write(const Options& options, const ReplaySession& session, OutputFolder& out) {
  runtime::write_durably(out.file("map.hmap"), [&](std::ostream& file) {
    nav::write_map_file(session.mapper().everything(), session.frame_loop().localisation().surfaces(), file);
  });
  write_floor(session.mapper().floor(), out);
  out.report(report_of(options, session));
  fmt::print("{}\n", out.list());
}

int play(const Options& options) {
  Interrupts interrupts;
  hal::MonotonicClock clock;
  ReplayPlayer player(options.file, options.page, clock);
  fmt::print("{}\nCtrl-C ends it\n", player.address());
  std::fflush(stdout);
  player.play([&] { return interrupts.asked(); });
  return kSuccess;
}

int run(const Options& options) {
  if (options.page.serve) return play(options);
  recording::McapReader first(options.file);
  ReplaySession session(first);
  std::optional<OutputFolder> out;
  if (!options.out.empty())
    out.emplace(options.out, "replay",
                std::initializer_list<const char*>{"map.hmap", "floor.pgm", "floor.yaml"});
  for (const std::filesystem::path& part : parts_of(options.file)) {
    recording::McapReader file(part);
    session.run(file);
    for (const recording::McapLoss& loss : file.losses())
      fmt::print("{}: {} bytes from {} on: {}\n", part.string(), loss.bytes, loss.at, loss.what);
  }
  const runtime::ReplayResult& result = session.result();
  if (result.difference) fmt::print("another plan: {}\n", *result.difference);
  if (result.missing) fmt::print("not to its end: {}\n", *result.missing);
  fmt::print("{}: {} frames and {} orders of {:.1f} s done again{}\n", options.file.string(), result.frames,
             result.orders, to_seconds(result.last - result.first),
             result.same() ? ": the same, bit by bit" : "");
  if (out) write(options, session, *out);
  return result.same() ? kSuccess : kNotReached;
}

}  // namespace

void add_replay(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "replay",
      "Do the work of a recording again, from images to plans, and compare each plan with the recorded");
  command
      ->add_option("recording", options->file, "The first file of a recording, e.g. recording_0001_00.mcap")
      ->required()
      ->type_name("FILE");
  command->add_option("--out", options->out, kOutHelp)->type_name("DIR");
  add_serve_options(*command, options->page);
  command->footer(
      "Takes the files that follow (_01, _02, ...) too. Example: headway replay "
      "build/rec/recording_0001_00.mcap\n"
      "Exit code 0 when every plan is the recorded one, bit by bit; 1 when one is not, or something is "
      "missing\n"
      "in the recording. On another kind of processor the last bits may differ.");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
