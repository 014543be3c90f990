// A machine that fails (a full disk) ends with exit code 3 and one line, a place where nobody may write with
// 2; nothing half written is left.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "app/commands.h"
#include "app/drawing.h"
#include "app/report.h"
#include "hal/error.h"
#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"
#include "vision/rig_files.h"

namespace headway::app {
namespace {

using test::Outcome, test::run_headway;

namespace fs = std::filesystem;

/// What is written to this file meets a full disk.
void make_full(const fs::path& file) {
  fs::create_directories(file.parent_path());
  fs::create_symlink("/dev/full", file);
}

std::vector<std::string> characterise(const fs::path& out) {
  return {"characterise", (source_dir() / "config/hrp2/rigs/bottom.yaml").string(), "--out", out.string()};
}

TEST(MachineFault, AFullDiskIsNoticedWhicheverFileMeetsIt) {
  for (const char* name : {"report.json", "field.ply", "field.png"}) {
    const TemporaryFolder folder;
    make_full(folder / "out" / (std::string(name) + ".part"));
    const Outcome result = run_headway(characterise(folder / "out"));
    EXPECT_EQ(result.code, kInternal) << name;
    EXPECT_NE(
        result.error.find(std::string(name) + ": cannot be written completely (No space left on device)"),
        std::string::npos)
        << result.error;
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << "one line";
    EXPECT_FALSE(fs::exists(folder / "out" / name));
  }
}

TEST(MachineFault, AFullDiskIsNoticedByARigFile) {
  const TemporaryFolder folder;
  make_full(folder / "rig.yaml");
  const auto rig = vision::read_rig(source_dir() / "config/hrp2/rigs/bottom.yaml");
  try {
    vision::write_rig(rig, folder / "rig.yaml");
    FAIL() << "was not noticed";
  } catch (const InputError& fault) {
    FAIL() << "blames the input: " << fault.what();
  } catch (const Error& fault) {
    EXPECT_NE(std::string(fault.what()).find("rig.yaml: cannot be written completely (No space"),
              std::string::npos)
        << fault.what();
  }
}

TEST(MachineFault, APlaceThatTakesNoFilesIsNamedAndSoIsTheRemedy) {
  const std::string rig = (source_dir() / "config/hrp2/rigs/bottom.yaml").string();
  const TemporaryFolder folder;
  write_text(folder / "map.pgm", "P5 2 2 255\n____");
  write_text(folder / "map.yaml",
             "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
             "free_thresh: 0.196\n");
  const std::string map = (folder / "map.yaml").string();
  const std::vector<std::string> all[] = {characterise("/proc"),  // not even from root
                                          {"rig", "convert", rig, "/proc/x.yaml"},
                                          {"map", "convert", map, "/proc/x.bt"},
                                          {"map", "convert", map, "/proc/x.hmap"}};
  for (const auto& arguments : all) {
    const Outcome result = run_headway(arguments);
    EXPECT_EQ(result.code, kBadInput) << arguments[0];
    EXPECT_NE(result.error.find("/proc"), std::string::npos) << result.error;
    EXPECT_NE(result.error.find(": cannot be written"), std::string::npos) << result.error;
    EXPECT_NE(result.error.find("), expected a folder that is there and that this user may write to"),
              std::string::npos)
        << result.error;
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << "one line";
  }
}

TEST(MachineFault, StandardOutputThatIsFullIsNoticed) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto on_full_output = [](std::vector<const char*> argv) {
    if (!std::freopen("/dev/full", "w", stdout)) std::_Exit(99);
    std::_Exit(run_program(static_cast<int>(argv.size()), argv.data()));
  };
  const std::string rig = (source_dir() / "config/hrp2/rigs/bottom.yaml").string();
  EXPECT_EXIT(on_full_output({"headway", "characterise", rig.c_str()}), testing::ExitedWithCode(kInternal),
              "headway: standard output cannot be written");
  EXPECT_EXIT(on_full_output({"headway", "--help"}), testing::ExitedWithCode(kInternal), "cannot be written");
}

}  // namespace
}  // namespace headway::app
