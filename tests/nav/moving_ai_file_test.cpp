#include "nav/moving_ai_file.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"

namespace headway::nav {
namespace {

using testing::HasSubstr;

FloorMap read(const std::string& text) {
  std::istringstream in(text);
  return read_moving_ai(in, "a.map", 0.1, at_seconds(3));
}

std::string complaint(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(MovingAiFile, HasItsLastRowAtTheBottom) {
  const FloorMap floor = read("type octile\nheight 2\nwidth 3\nmap\n.GS\r\n@TW\n");
  EXPECT_EQ(floor.grid, (FloorGrid{0.1, {0, 0}, 3, 2}));
  for (int x = 0; x < 3; ++x) {
    EXPECT_EQ(floor.at({x, 0}), Floor::kBlocked);
    EXPECT_EQ(floor.at({x, 1}), Floor::kFree);
    EXPECT_EQ(floor.seen({x, 0}), at_seconds(3));
  }
}

RC_GTEST_PROP(MovingAiFile, GivesBackEveryCell, ()) {
  const int width = *rc::gen::inRange(1, 30), height = *rc::gen::inRange(1, 30);
  std::vector<std::string> rows;
  for (int y = 0; y < height; ++y) {
    rows.emplace_back();
    for (int x = 0; x < width; ++x) rows.back() += *rc::gen::element('.', '@', 'T', 'G');
  }
  std::string text =
      "type octile\nheight " + std::to_string(height) + "\nwidth " + std::to_string(width) + "\nmap\n";
  for (const std::string& row : rows) text += row + "\n";
  const FloorMap floor = read(text);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const char symbol = rows[static_cast<std::size_t>(height - 1 - y)][static_cast<std::size_t>(x)];
      const bool blocked = symbol == '@' || symbol == 'T';
      RC_ASSERT(floor.at({x, y}) == (blocked ? Floor::kBlocked : Floor::kFree));
    }
}

TEST(MovingAiFile, SaysWhatIsWrongAndWhere) {
  const std::string head = "type octile\nheight 2\nwidth 3\nmap\n";
  EXPECT_THAT(complaint(""), HasSubstr("a.map:1: the file ends, expected 'type octile'"));
  EXPECT_THAT(complaint("type tile\n"), HasSubstr("a.map:1: expected 'type octile'"));
  EXPECT_THAT(complaint("type octile\nheight 0\n"), HasSubstr("a.map:2: expected 'height N'"));
  EXPECT_THAT(complaint("type octile\nheight 2\nwidth 3x\n"), HasSubstr("a.map:3: expected 'width N'"));
  EXPECT_THAT(complaint("type octile\nheight 30000\nwidth 30000\nmap\n"), HasSubstr("are more than"));
  EXPECT_THAT(complaint(head + "...\n"), HasSubstr("a.map:6: the file ends, expected 2 rows"));
  EXPECT_THAT(complaint(head + "....\n...\n"), HasSubstr("a.map:5: has 4 columns, expected 3"));
  EXPECT_THAT(complaint(head + "...\n.x.\n"), HasSubstr("a.map:6: column 2: unknown terrain"));
  EXPECT_THROW(read_moving_ai("no/such.map", 0.1), InputError);
}

TEST(MovingAiFile, ReadsABenchmarksMap) {
  const char* data = std::getenv("HEADWAY_DATA");
  if (data == nullptr) GTEST_SKIP() << "HEADWAY_DATA is not set: no Moving AI maps";
  const std::string file = std::string(data) + "/maps/cities_Berlin_0_512.map";
  const FloorMap floor = read_moving_ai(file, 0.05);
  EXPECT_EQ(floor.grid.width, 512);
  EXPECT_EQ(floor.grid.height, 512);
  // Counted in the text itself.
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto map = text.substr(text.find("\nmap\n") + 5);
  EXPECT_EQ(std::count(floor.cells.begin(), floor.cells.end(), Floor::kFree),
            std::count(map.begin(), map.end(), '.') + std::count(map.begin(), map.end(), 'G') +
                std::count(map.begin(), map.end(), 'S'));
}

}  // namespace
}  // namespace headway::nav
