#include "nav/floor_files.h"

#include <fstream>
#include <iterator>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "tests/temporary_folder.h"

namespace headway::nav {
namespace {

using testing::HasSubstr;

FloorMap any_floor() {
  FloorMap floor =
      unseen_floor({*rc::gen::element(0.05, 0.1, 0.02),
                    {*rc::gen::inRange(-1000, 1000) * 0.05, *rc::gen::inRange(-1000, 1000) * 0.05},
                    *rc::gen::inRange(1, 40),
                    *rc::gen::inRange(1, 40)});
  for (auto& cell : floor.cells) cell = *rc::gen::element(Floor::kUnseen, Floor::kFree, Floor::kBlocked);
  return floor;
}

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

constexpr const char* kYaml =
    "image: floor.pgm\nresolution: 0.05\norigin: [-1, -2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: "
    "0.196\n";
const std::string kPgm = std::string("P5\n3 2\n255\n") + '\x00' + '\xfe' + '\xcd' + '\xfe' + '\xfe' + '\x00';

RC_GTEST_PROP(FloorFiles, GiveBackWhatWasWritten, ()) {
  const FloorMap floor = any_floor();
  const TemporaryFolder folder;
  write_map_server(floor, folder.path());
  const FloorMap read = read_map_server(folder / "floor.yaml", at_seconds(9));
  RC_ASSERT(read.grid.width == floor.grid.width);
  RC_ASSERT(read.grid.height == floor.grid.height);
  RC_ASSERT(read.grid.resolution == floor.grid.resolution);
  RC_ASSERT(read.grid.origin == floor.grid.origin);
  RC_ASSERT(read.cells == floor.cells);
  for (std::size_t i = 0; i < read.cells.size(); ++i) {
    RC_ASSERT(read.seen_at[i] == (read.cells[i] == Floor::kUnseen ? kNever : at_seconds(9)));
  }
}

TEST(FloorFiles, FollowMapServersConvention) {
  FloorMap floor = unseen_floor({0.05, {-1, -2}, 3, 2});
  floor.cells = {Floor::kFree,    Floor::kFree, Floor::kBlocked,  // lowest y: the file's last row
                 Floor::kBlocked, Floor::kFree, Floor::kUnseen};  //
  const TemporaryFolder folder;
  write_map_server(floor, folder.path());
  EXPECT_EQ(contents(folder / "floor.pgm"), kPgm);
  EXPECT_EQ(contents(folder / "floor.yaml"), kYaml);
}

TEST(FloorFiles, AreReadWithCommentsNegationThresholdsAndAsciiPixels) {
  const TemporaryFolder folder;
  write(folder / "a.yaml",
        "image: a.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 1\noccupied_thresh: 0.5\nfree_thresh: "
        "0.3\nmode: "
        "trinary\n");
  write(folder / "a.pgm", "P2 # made by hand\n# two comments\n4 1\n255\n0 76 # row\n77 128");
  const FloorMap floor = read_map_server(folder / "a.yaml");
  EXPECT_THAT(floor.cells, testing::ElementsAre(Floor::kFree, Floor::kFree, Floor::kUnseen, Floor::kBlocked));
}

std::string complaint(const std::string& yaml, const std::string& pgm) {
  const TemporaryFolder folder;
  write(folder / "floor.yaml", yaml);
  write(folder / "floor.pgm", pgm);
  try {
    read_map_server(folder / "floor.yaml");
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(FloorFiles, SayWhatIsWrongWithAMalformedMap) {
  EXPECT_EQ(complaint(kYaml, kPgm), "accepted");
  EXPECT_THAT(complaint(replaced(kYaml, "0.05", "-1"), kPgm), HasSubstr("floor.yaml:2: resolution"));
  EXPECT_THAT(complaint(replaced(kYaml, "-2, 0]", "-2]"), kPgm), HasSubstr("floor.yaml:3: origin"));
  EXPECT_THAT(complaint(replaced(kYaml, "-2, 0]", "-2, 0.5]"), kPgm), HasSubstr("yaw 0"));
  EXPECT_THAT(complaint(replaced(kYaml, "0.196", "0.9"), kPgm), HasSubstr("free_thresh"));
  EXPECT_THAT(complaint(replaced(kYaml, "negate", "negative"), kPgm), HasSubstr("negative"));
  EXPECT_THAT(complaint(replaced(kYaml, "floor.pgm", "other.pgm"), kPgm), HasSubstr("other.pgm"));
  EXPECT_THAT(complaint(kYaml, kPgm.substr(0, kPgm.size() - 1)),
              HasSubstr("floor.pgm: ends after 5 of 6 pixels"));
  EXPECT_THAT(complaint(kYaml, replaced(kPgm, "P5", "P6")), HasSubstr("P5 or P2"));
  EXPECT_THAT(complaint(kYaml, replaced(kPgm, "3 2", "3 -2")), HasSubstr("height"));
  EXPECT_THAT(complaint(kYaml, replaced(kPgm, "3 2", "30000 30000")), HasSubstr("more than the 100000000"));
  EXPECT_THAT(complaint(kYaml, replaced(kPgm, "3 2", "9000 9000")), HasSubstr("ends after 6 of 81000000"));
  EXPECT_THAT(complaint(kYaml, "P2 9000 9000 255 0 0"), HasSubstr("pixel: expected a whole number"));
  EXPECT_THAT(complaint(kYaml, replaced(kPgm, "255", "65535")), HasSubstr("8-bit"));
  EXPECT_THAT(complaint(kYaml, ""), HasSubstr("P5 or P2"));
  const TemporaryFolder folder;
  EXPECT_THROW(read_map_server(folder / "none.yaml"), InputError);
  EXPECT_THROW(write_map_server(unseen_floor({0.05, {0, 0}, 2, 2}), folder / "none"), InputError);
}

TEST(FloorFiles, AreReadOrRefusedHoweverMutated) {
  std::mt19937_64 random(1);
  const std::string yaml = kYaml;
  int refused = 0;
  for (int round = 0; round < 400; ++round) {
    std::string text = round % 2 ? yaml : kPgm;
    for (int k = 0; k <= round % 3; ++k) text[random() % text.size()] = static_cast<char>(random() & 255);
    if (round % 5 == 0) text.resize(random() % text.size());
    refused += complaint(round % 2 ? text : yaml, round % 2 ? kPgm : text) != "accepted";
  }
  EXPECT_GT(refused, 100);
  EXPECT_LT(refused, 400);
}

}  // namespace
}  // namespace headway::nav
