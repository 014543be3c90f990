#include "app/output_folder.h"

#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;

void run(const fs::path& folder, const std::string& command, const std::vector<std::string>& names) {
  OutputFolder out(folder, command);
  for (const std::string& name : names) write_text(out.file(name), "new");
  out.report({{"seed", 1}});
}

std::string refusal_of(const fs::path& folder, const std::string& command) {
  try {
    OutputFolder out(folder, command);
  } catch (const InputError& fault) {
    return fault.what();
  }
  return "";
}

TEST(OutputFolder, RemovesWhatTheEarlierRunWroteAndNothingElse) {
  const TemporaryFolder folder;
  write_text(folder / "notes.txt", "mine");
  run(folder.path(), "sim", {"plan.png", "replan.png"});
  write_text(folder / "replan_2.png", "mine too");
  run(folder.path(), "sim", {"plan.png"});
  EXPECT_TRUE(fs::exists(folder / "plan.png"));
  EXPECT_FALSE(fs::exists(folder / "replan.png")) << "of the earlier run";
  EXPECT_TRUE(fs::exists(folder / "notes.txt"));
  EXPECT_TRUE(fs::exists(folder / "replan_2.png"));
}

TEST(OutputFolder, LeavesNothingOfARunThatEndsWithoutItsReport) {
  const TemporaryFolder folder;
  write_text(folder / "notes.txt", "mine");
  {
    OutputFolder out(folder.path(), "sim");
    write_text(out.file("plan.png"), "new");
    OutputFolder below = out.below("part");
    write_text(below.file("plan.png"), "new");
    below.report(Json::object());
  }
  EXPECT_FALSE(fs::exists(folder / "plan.png"));
  EXPECT_FALSE(fs::exists(folder / "part"));
  EXPECT_TRUE(fs::exists(folder / "notes.txt"));
  { const OutputFolder made(folder / "a/b", "sim"); }
  EXPECT_FALSE(fs::exists(folder / "a"));
}

TEST(OutputFolder, RefusesToWriteOverWhatIsNotItsOwn) {
  const TemporaryFolder folder;
  write_text(folder / "plan.png", "mine");
  {
    OutputFolder out(folder.path(), "sim");
    write_text(out.file("a.png"), "new");
    EXPECT_THROW(out.file("plan.png"), InputError);
  }
  EXPECT_FALSE(fs::exists(folder / "a.png"));
  EXPECT_EQ(read_text(folder / "plan.png"), "mine");
  EXPECT_THROW(OutputFolder(folder.path(), "sim", {"plan.png"}), InputError);
}

TEST(OutputFolder, HasNoReportWhileARunIsUnderWay) {
  const TemporaryFolder folder;
  run(folder.path(), "sim", {"plan.png"});
  const OutputFolder out(folder.path(), "sim");
  EXPECT_FALSE(fs::exists(folder / "report.json"));
}

TEST(OutputFolder, RefusesTheFolderOfAnotherCommandAndLeavesItAlone) {
  const TemporaryFolder folder;
  run(folder.path(), "calibrate", {"rig.yaml"});
  EXPECT_NE(
      refusal_of(folder.path(), "characterise").find("report.json: is the report of 'headway calibrate'"),
      std::string::npos);
  EXPECT_TRUE(fs::exists(folder / "rig.yaml"));
  EXPECT_EQ(refusal_of(folder.path(), "calibrate"), "");
  for (const char* strange : {"{\"command\": 3}", "[]", "no JSON", ""}) {
    write_text(folder / "report.json", strange);
    EXPECT_NE(refusal_of(folder.path(), "sim").find("is the report of something else"), std::string::npos)
        << strange;
    EXPECT_EQ(read_text(folder / "report.json"), strange);
  }
}

TEST(OutputFolder, FollowsNoNameOutOfItself) {
  const TemporaryFolder folder;
  const fs::path out = folder / "out";
  write_text(folder / "mine.txt", "mine");
  write_text(out / "deep/mine.txt", "mine");
  fs::create_directories(folder / "elsewhere");
  write_text(folder / "elsewhere/mine.txt", "mine");
  fs::create_directory_symlink(folder / "elsewhere", out / "link");
  write_text(folder / "elsewhere/report.json", R"({"command": "sim", "files": ["mine.txt"]})");
  const Json report = {{"command", "sim"},
                       {"files",
                        {"../mine.txt", "..", ".", "", "/", "deep", "deep/", "deep/mine.txt", "link/",
                         (folder / "mine.txt").string(), 7}}};
  write_text(out / "report.json", report.dump());
  EXPECT_EQ(refusal_of(out, "sim"), "");
  EXPECT_TRUE(fs::exists(folder / "mine.txt"));
  EXPECT_TRUE(fs::exists(out / "deep/mine.txt"));
  EXPECT_TRUE(fs::exists(folder / "elsewhere/mine.txt"));
}

TEST(OutputFolder, RemovesTheFoldersOfParts) {
  const TemporaryFolder folder;
  const auto campaign = [&](const std::vector<std::string>& lost) {
    OutputFolder out(folder.path(), "campaign");
    for (const std::string& world : lost) {
      OutputFolder below = out.below(world);
      write_text(below.file("plan.png"), "new");
      below.report(Json::object());
    }
    out.report(Json::object());
  };
  campaign({"world_001", "world_002"});
  write_text(folder / "world_002/notes.txt", "mine");
  campaign({});
  EXPECT_FALSE(fs::exists(folder / "world_001"));
  EXPECT_TRUE(fs::exists(folder / "world_002/notes.txt"));
  EXPECT_FALSE(fs::exists(folder / "world_002/plan.png"));
}

TEST(OutputFolder, SaysInItsReportAndItsLineWhatWasWritten) {
  const TemporaryFolder folder;
  OutputFolder out(folder.path(), "map");
  out.file("b.png"), out.file("a.png"), out.file("b.png");
  out.report({{"points", 3}});
  EXPECT_EQ(Json::parse(read_text(folder / "report.json")),
            Json({{"command", "map"}, {"points", 3}, {"files", {"b.png", "a.png"}}}));
  EXPECT_EQ(out.list(), folder.path().string() + ": report.json, b.png, a.png");
}

}  // namespace
}  // namespace headway::app
