// What users see when a configuration file is wrong: one line that names file, line and key.
#include "config/yaml_reader.h"

#include <filesystem>
#include <fstream>
#include <limits>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::config {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr Range kAny{-kInf, kInf};

Section parse(const std::string& text) { return Section::parse(text, "robot.yaml"); }

// The message of the InputError that `act` throws; "" when it throws none.
template <class Act>
std::string complaint(Act act) {
  try {
    act();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

std::string number_complaint(const std::string& value, Range allowed = {0, 10, "m"}) {
  return complaint([&] { parse("width: " + value).number("width", allowed); });
}

TEST(YamlReader, ReadsEveryKindOfValue) {
  const Section s = parse(
      "width: 1.5\ncount: 7\non: true\nname: HRP-2\nkind: box\nsize: [1, 2, 3]\n"
      "arm: {length: 0.4}\nboxes:\n  - {x: 1}\n  - {x: 2}\n");
  EXPECT_EQ(s.number("width", {0, 2, "m"}), 1.5);
  EXPECT_EQ(s.integer("count", {0, 10}), 7);
  EXPECT_TRUE(s.flag_or("on", false));
  EXPECT_EQ(s.text("name"), "HRP-2");
  EXPECT_EQ(s.choice("kind", {"box", "plane"}), "box");
  EXPECT_EQ(s.numbers("size", 3, kAny), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(s.section("arm").number("length", kAny), 0.4);
  const auto boxes = s.sections("boxes");
  ASSERT_EQ(boxes.size(), 2U);
  EXPECT_EQ(boxes[0].integer("x", kAny), 1);
  EXPECT_EQ(boxes[1].integer("x", kAny), 2);
  EXPECT_NO_THROW(s.finish());
}

TEST(YamlReader, ReadsListsOfSomeLengthAndMatrices) {
  const Section s = parse("short: [1, 2]\nmatrix: [[1, 2], [3, 4], [5, 6]]\nragged: [[1, 2], [3]]\n");
  EXPECT_EQ(s.numbers_between("short", 1, 3, kAny), (std::vector<double>{1, 2}));
  EXPECT_EQ(complaint([&] { s.numbers_between("short", 3, 5, kAny); }),
            "robot.yaml:1: short: a list of 2, expected a list of 3 to 5 numbers");
  EXPECT_EQ(s.matrix("matrix", 3, 2, kAny), (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(complaint([&] { s.matrix("matrix", 2, 3, kAny); }),
            "robot.yaml:2: matrix: a list, expected a list of 2 lists of 3 numbers");
  EXPECT_EQ(complaint([&] { s.matrix("ragged", 2, 2, kAny); }),
            "robot.yaml:3: ragged: a list, expected a list of 2 lists of 2 numbers");
  EXPECT_EQ(complaint([&] { s.matrix("short", 2, 1, kAny); }),
            "robot.yaml:1: short: a list, expected a list of 2 lists of 1 numbers");
}

TEST(YamlReader, GivesTheFallbackOfWhatIsAbsent) {
  const Section s = parse("width: 1\n");
  EXPECT_EQ(s.number_or("height", 2.5, kAny), 2.5);
  EXPECT_EQ(s.integer_or("count", 3, kAny), 3);
  EXPECT_TRUE(s.flag_or("on", true));
  EXPECT_EQ(s.text_or("name", "none"), "none");
  EXPECT_EQ(s.choice_or("kind", "box", {"box"}), "box");
  EXPECT_FALSE(s.numbers_if("size", 3, kAny));
  EXPECT_FALSE(s.section_if("arm"));
  EXPECT_TRUE(s.sections("boxes").empty());
}

RC_GTEST_PROP(YamlReader, GivesBackEveryNumberThatWasWritten, (double number)) {
  RC_ASSERT(parse(fmt::format("width: {}\n", number)).number("width", kAny) == number);
}

RC_GTEST_PROP(YamlReader, RefusesExactlyTheNumbersOutsideTheRange, (int number, int a, int b)) {
  const Range allowed{static_cast<double>(std::min(a, b)), static_cast<double>(std::max(a, b))};
  const bool inside = number >= std::min(a, b) && number <= std::max(a, b);
  RC_ASSERT(number_complaint(std::to_string(number), allowed).empty() == inside);
}

RC_GTEST_PROP(YamlReader, NamesTheLineOfTheFault, ()) {
  // A file of numbered keys with comments and empty lines between; one of them holds a word.
  const int keys = *rc::gen::inRange(1, 30);
  const int bad = *rc::gen::inRange(0, keys);
  const bool nested = *rc::gen::arbitrary<bool>();
  std::string text = nested ? "arm:\n" : "";
  int line = nested ? 1 : 0, bad_line = 0;
  for (int i = 0; i < keys; ++i) {
    for (int gap = *rc::gen::inRange(0, 3); gap > 0; --gap, ++line) text += gap == 1 ? "# width: 3\n" : "\n";
    text += fmt::format("{}key{}: {}\n", nested ? "  " : "", i, i == bad ? "wide" : "1");
    ++line;
    if (i == bad) bad_line = line;
  }
  const std::string message = complaint([&] {
    const Section root = parse(text);
    const Section s = nested ? root.section("arm") : root;
    for (int i = 0; i < keys; ++i) s.number(fmt::format("key{}", i), kAny);
  });
  RC_ASSERT(message == fmt::format("robot.yaml:{}: {}key{}: 'wide', expected a number", bad_line,
                                   nested ? "arm." : "", bad));
}

TEST(YamlReader, SaysWhatANumberMayBe) {
  EXPECT_EQ(number_complaint("12"), "robot.yaml:1: width: '12', expected a number from 0 to 10 m");
  EXPECT_EQ(number_complaint("-1", {0, kInf, "m"}),
            "robot.yaml:1: width: '-1', expected a number of at least 0 m");
  EXPECT_EQ(number_complaint("5", {-kInf, 4}), "robot.yaml:1: width: '5', expected a number of at most 4");
}

TEST(YamlReader, RefusesWhatIsNotAFiniteNumber) {
  for (const char* value : {".nan", ".inf", "-.inf", "nan", "inf", "1e999", "wide", "1 m", "1,5", "1_000",
                            "0x10", "''", "~", "", "[1]", "{a: 1}", "!!str", "1..2", "--1"})
    EXPECT_THAT(number_complaint(value, kAny),
                AllOf(StartsWith("robot.yaml:1: width: "), HasSubstr("expected a number")))
        << value;
}

TEST(YamlReader, RefusesWhatIsNotAWholeNumber) {
  for (const char* value : {"1.5", ".nan", ".inf", "3e9", "-3e9", "two", "[1]"})
    EXPECT_THAT(complaint([&] { parse(fmt::format("count: {}", value)).integer("count", kAny); }),
                AllOf(StartsWith("robot.yaml:1: count: "), HasSubstr("expected a whole number")))
        << value;
  EXPECT_EQ(complaint([] {
              parse("count: 11").integer("count", {1, 10});
            }),
            "robot.yaml:1: count: '11', expected a whole number from 1 to 10");
}

TEST(YamlReader, RefusesValuesOfAnotherKind) {
  const Section s =
      parse("flag: maybe\ntext: [a]\nkind: sphere\nsize: [1, 2]\nsizes: [1, x]\narm: 3\nboxes: {}\n");
  EXPECT_EQ(complaint([&] { s.flag_or("flag", true); }),
            "robot.yaml:1: flag: 'maybe', expected true or false");
  EXPECT_EQ(complaint([&] { s.text("text"); }), "robot.yaml:2: text: a list, expected a text");
  EXPECT_EQ(complaint([&] {
              s.choice("kind", {"box", "plane"});
            }),
            "robot.yaml:3: kind: 'sphere', expected one of: box, plane");
  EXPECT_EQ(complaint([&] { s.numbers("size", 3, kAny); }),
            "robot.yaml:4: size: a list of 2, expected a list of 3 numbers");
  EXPECT_EQ(complaint([&] { s.numbers("sizes", 2, kAny); }), "robot.yaml:5: sizes: 'x', expected a number");
  EXPECT_EQ(complaint([&] { s.section("arm"); }), "robot.yaml:6: arm: '3', expected a mapping (key: value)");
  EXPECT_EQ(complaint([&] { s.sections("boxes"); }), "robot.yaml:7: boxes: a mapping, expected a list");
}

TEST(YamlReader, NamesTheEntryOfAList) {
  const Section s = parse("boxes:\n  - {x: 1}\n  - {x: wide}\n  - 3\n");
  EXPECT_EQ(complaint([&] { s.sections("boxes"); }),
            "robot.yaml:4: boxes[2]: '3', expected a mapping (key: value)");
  const Section good = parse("boxes:\n  - {x: 1}\n  - {x: wide}\n");
  EXPECT_EQ(complaint([&] { good.sections("boxes")[1].number("x", kAny); }),
            "robot.yaml:3: boxes[1].x: 'wide', expected a number");
}

TEST(YamlReader, SaysWhichKeyIsMissing) {
  EXPECT_EQ(complaint([] { parse("a: 1\n").number("b", kAny); }), "robot.yaml:1: the key 'b' is missing");
  EXPECT_EQ(complaint([] { parse("a: 1\narm:\n  length: 2\n").section("arm").number("mass", kAny); }),
            "robot.yaml:3: arm: the key 'mass' is missing");
}

TEST(YamlReader, RefusesAKeyThatNobodyAskedFor) {
  const Section s = parse("width: 1\nheigth: 2\n");
  s.number("width", kAny);
  s.number_or("height", 1, kAny);
  EXPECT_EQ(complaint([&] { s.finish(); }),
            "robot.yaml:2: heigth: is not a key here, did you mean 'height'?");
}

TEST(YamlReader, NamesTheMisspeltKeyInPlaceOfTheOneThatIsMissing) {
  EXPECT_EQ(complaint([] { parse("name: a\nbaselin: 0.1\n").number("baseline", kAny); }),
            "robot.yaml:2: baselin: is not a key here, did you mean 'baseline'?");
  const Section known = parse("cam1: 1\ncam3: 2\nhight: 3\n");
  known.number("hight", kAny);
  EXPECT_EQ(complaint([&] { known.number("height", kAny); }), "robot.yaml:1: the key 'height' is missing")
      << "a key that is used is no typo";
  EXPECT_EQ(complaint([&] { known.number("cam2", kAny); }), "robot.yaml:1: the key 'cam2' is missing");
  const Section both = parse("height: 1\nheigth: 2\n");
  both.number("height", kAny);
  EXPECT_EQ(complaint([&] { both.finish(); }),
            "robot.yaml:2: heigth: is not a key here, expected one of: height");
}

TEST(YamlReader, RefusesWhatIsNoTextWithoutTheParsersWords) {
  EXPECT_EQ(complaint([] { parse(std::string("\xff\xd8\xff\xe0\0\x10JFIF", 10)); }),
            "robot.yaml: not a text file, expected YAML");
}

TEST(YamlReader, RefusesUnknownKeysOfTheSectionsBelow) {
  const Section s = parse("arm:\n  length: 1\n  colour: red\nboxes:\n  - x: 1\n    y: 2\n");
  s.section("arm").number("length", kAny);
  EXPECT_EQ(complaint([&] { s.section("arm").finish(); }),
            "robot.yaml:3: arm.colour: is not a key here, expected one of: length");
  s.section("arm").text("colour");
  s.sections("boxes")[0].number("x", kAny);
  EXPECT_EQ(complaint([&] { s.finish(); }),
            "robot.yaml:6: boxes[0].y: is not a key here, expected one of: x");
}

TEST(YamlReader, FinishesASectionBeforeTheRestIsRead) {
  const Section s = parse("arm: {length: 1}\nwidth: 1\n");
  s.section("arm").number("length", kAny);
  EXPECT_NO_THROW(s.section("arm").finish());
  EXPECT_THAT(complaint([&] { s.finish(); }), StartsWith("robot.yaml:2: width: is not a key here"));
}

TEST(YamlReader, RemembersKeysReadThroughEverySectionOfTheSameMapping) {
  const Section s = parse("arm: {length: 1, mass: 2}\nboxes: [{x: 1, y: 2}]\n");
  s.section("arm").number("length", kAny);
  s.section("arm").number("mass", kAny);
  s.sections("boxes")[0].number("x", kAny);
  s.sections("boxes")[0].number("y", kAny);
  EXPECT_NO_THROW(s.finish());
}

TEST(YamlReader, ReadsAnAliasLikeItsAnchor) {
  const Section s = parse("left: &foot {length: 0.24}\nright: *foot\nboxes: [*foot, *foot]\n");
  EXPECT_EQ(s.section("left").number("length", kAny), 0.24);
  EXPECT_EQ(s.section("right").number("length", kAny), 0.24);
  EXPECT_EQ(s.sections("boxes")[1].number("length", kAny), 0.24);
  EXPECT_NO_THROW(s.finish());
}

TEST(YamlReader, RefusesAKeyThatStandsTwice) {
  const std::string message = complaint([] { parse("a: 1\nb: 2\na: 3\n").number("a", kAny); });
  EXPECT_EQ(message, "robot.yaml:3: a: stands here twice, expected once; the first is in line 1");
}

TEST(YamlReader, RefusesWhatIsNotAMapping) {
  for (const char* text : {"", "# only a comment\n", "~", "- 1\n- 2\n", "just words", "42"})
    EXPECT_THAT(complaint([&] { parse(text); }),
                AllOf(StartsWith("robot.yaml: holds "), HasSubstr("expected a mapping")))
        << text;
}

TEST(YamlReader, RefusesASecondDocument) {
  EXPECT_THAT(complaint([] { parse("a: 1\n---\nb: 2\n"); }),
              MatchesRegex("robot.yaml:[23]: more text after the end.*expected one document"));
  // Here yaml-cpp's own LoadAll never ends.
  EXPECT_THAT(complaint([] { parse("{a: 1},"); }), HasSubstr("expected one document"));
}

TEST(YamlReader, PointsAtBrokenSyntax) {
  EXPECT_THAT(complaint([] { parse("a: 1\nb: [1, 2\nc: 3\n"); }),
              MatchesRegex("robot.yaml:[0-9]+: not valid YAML: .*"));
  EXPECT_THAT(complaint([] { parse("a: 1\n  b: 2\n"); }), StartsWith("robot.yaml:2: not valid YAML: "));
  EXPECT_THAT(complaint([] { parse("a: *nobody\n"); }), StartsWith("robot.yaml:1: not valid YAML: "));
}

TEST(YamlReader, SaysOneLineWhateverTheValueHolds) {
  for (const char* value : {"\"two\\nlines\"", "\"\\e[31mred\\0\"", "|\n  many\n  lines\n"}) {
    const std::string message = number_complaint(value);
    EXPECT_THAT(message, StartsWith("robot.yaml:1: width: "));
    for (const char c : message) EXPECT_GE(c, ' ') << message;
  }
  EXPECT_THAT(number_complaint("\"\\x9b31mred\\x85\""), HasSubstr("' 31mred '"));
  // No character: a byte that goes on, a surrogate, one longer than need be, one beyond U+10FFFF, half of
  // one.
  for (const char* none : {"\x80", "\xED\xA0\x80", "\xC0\xAF", "\xF4\x90\x80\x80", "\xE2\x82"})
    EXPECT_THAT(number_complaint(none), HasSubstr("'?")) << none;
  EXPECT_THAT(number_complaint("\u00B0\u20AC\U0001F916"), HasSubstr("'\u00B0\u20AC\U0001F916'"));

  EXPECT_LT(number_complaint(std::string(10000, 'x')).size(), 200U);
  const Section s = parse(fmt::format("\"a\\nb{}\": 1\n", std::string(900, 'k')));
  const std::string message = complaint([&] { s.finish(); });
  EXPECT_THAT(message, AllOf(HasSubstr("is not a key here"), Not(HasSubstr("\n"))));
  EXPECT_LT(message.size(), 300U);
}

TEST(YamlReader, TakesNoTextThatReportsCouldNotHold) {
  EXPECT_EQ(parse("name: J\u00FCrgen\n").text("name"), "J\u00FCrgen");
  EXPECT_THAT(complaint([] { parse("a: 1\nname: J\xFCrgen\n").text("name"); }),
              StartsWith("robot.yaml:2: name: 'J?rgen', expected a text in UTF-8"));
}

TEST(YamlReader, RefusesDeepNesting) {
  for (const char* open : {"[", "{a: ", "- ", "? "}) {
    std::string text = "a: \n  ";
    for (int i = 0; i < 20000; ++i) text += open;
    EXPECT_THAT(complaint([&] { parse(text); }), StartsWith("robot.yaml:")) << open;
  }
  std::string stairs;
  for (int i = 0; i < 40; ++i) stairs += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_THAT(complaint([&] { parse(stairs); }), HasSubstr("nested too deep, expected at most 32"));
}

TEST(YamlReader, IsNotBlownUpByAliasesOfAliases) {
  std::string text = "a0: &a0 {x: 1}\n";
  for (int i = 1; i < 30; ++i)
    text += fmt::format("a{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}]\n", i,
                        i - 1);
  const Section s = parse(text);
  EXPECT_EQ(s.sections("a1").size(), 9U);
  EXPECT_THAT(complaint([&] { s.sections("a29"); }), HasSubstr("expected a mapping"));
  EXPECT_THAT(complaint([&] { s.finish(); }), HasSubstr("is not a key here"));
}

TEST(YamlReader, EndsOnAMappingThatHoldsItself) {
  const Section s = parse("a: &a {b: *a, x: 1}\n");
  Section below = s.section("a");
  for (int i = 0; i < 5; ++i) below = below.section("b");
  EXPECT_EQ(below.number("x", kAny), 1);
  EXPECT_NO_THROW(s.finish());
}

TEST(YamlReader, RefusesHugeTexts) {
  std::string many = "a: [";
  for (int i = 0; i < 120000; ++i) many += "1,";
  EXPECT_THAT(complaint([&] { parse(many + "1]"); }), HasSubstr("expected at most 100000 values"));
  EXPECT_THAT(complaint([&] { parse("a: " + std::string(2 << 20, 'x')); }),
              HasSubstr("expected at most 1048576"));
}

// A file like the ones that users write, with every kind of value, and a program that reads all of it.
const std::string kWorld = R"(# a world
name: moving box   # words
seed: 7
floor: {size: [6.0, 4.0], texture: wood}
start: [0.5, 0.5, 0]
robot: &robot
  folder: ../hrp2
  speed: 1.5e-1
  mirror: false
boxes:
  - {name: "table", size: [0.8, 0.8, 0.7], at: [2, 1, 0.35]}
  - name: 'slider'
    size: [0.3, 0.3, 0.5]
    at: [3, -1, 0.25]
    moving: {velocity: [0, 0.2, 0], from: 4.0}
copy: *robot
)";

void read_robot(const Section& robot) {
  robot.path("folder");
  robot.number("speed", {0, 1, "m/s"});
  robot.flag_or("mirror", true);
}

void read_world(const std::string& text) {
  const Section world = parse(text);
  world.text("name");
  world.integer("seed", {0, 1000});
  const Section floor = world.section("floor");
  floor.numbers("size", 2, {0, 100, "m"});
  floor.choice("texture", {"wood", "concrete"});
  world.numbers("start", 3, kAny);
  read_robot(world.section("robot"));
  read_robot(world.section("copy"));
  for (const Section& box : world.sections("boxes")) {
    box.text_or("name", "box");
    box.numbers("size", 3, {0, 10, "m"});
    box.numbers("at", 3, {-100, 100, "m"});
    if (const auto moving = box.section_if("moving")) {
      moving->numbers_if("velocity", 3, {-2, 2, "m/s"});
      moving->number_or("from", 0, {0, kInf, "s"});
    }
  }
  world.finish();
}

// Whatever the text, reading ends with success or with one clear line; any other exception fails the test.
void expect_clear_end(const std::string& text) {
  const std::string message = complaint([&] { read_world(text); });
  if (message.empty()) return;
  RC_ASSERT(message.starts_with("robot.yaml:"));
  RC_ASSERT(std::all_of(message.begin(), message.end(),
                        [](char c) { return static_cast<unsigned char>(c) >= 0x20; }));
  RC_ASSERT(message.size() < 600);
}

TEST(YamlReader, ReadsTheWorldThatTheNextTestsBreak) {
  EXPECT_EQ(complaint([] { read_world(kWorld); }), "");
}

TEST(YamlReader, EndsClearlyOnEveryTruncation) {
  int refused = 0;
  for (std::size_t size = 0; size < kWorld.size(); ++size) {
    const std::string message = complaint([&] { read_world(kWorld.substr(0, size)); });
    if (message.empty()) continue;
    ++refused;
    EXPECT_THAT(message, AllOf(StartsWith("robot.yaml:"), Not(HasSubstr("\n"))));
  }
  // All but the last few cuts lose something that is needed.
  EXPECT_GT(refused, static_cast<int>(kWorld.size()) - 5);
}

RC_GTEST_PROP(YamlReader, EndsClearlyOnMutatedText, ()) {
  static const std::vector<std::string> kPieces = {"\n",      " ",
                                                   "\t",      ":",
                                                   ": ",      "- ",
                                                   "? ",      "[",
                                                   "]",       "{",
                                                   "}",       ",",
                                                   "&a ",     "*a",
                                                   "*robot",  "!!int ",
                                                   "|",       ">",
                                                   "'",       "\"",
                                                   "%",       "#",
                                                   "---\n",   "...\n",
                                                   "<<: ",    "\\",
                                                   "~",       ".nan",
                                                   "1e999",   std::string(1, '\0'),
                                                   "\xff",    "\xef\xbb\xbf",
                                                   "\xfe\xff"};
  for (int round = 0; round < 40; ++round) {
    std::string text = kWorld;
    for (int edits = *rc::gen::inRange(1, 6); edits > 0; --edits) {
      const auto at = *rc::gen::inRange<std::size_t>(0, text.size() + 1);
      const auto length = std::min(text.size() - at, *rc::gen::inRange<std::size_t>(0, 8));
      switch (*rc::gen::inRange(0, 4)) {
        case 0:
          text.erase(at, length);
          break;
        case 1:
          text.insert(at, *rc::gen::elementOf(kPieces));
          break;
        case 2:
          text.insert(at, text.substr(*rc::gen::inRange<std::size_t>(0, text.size() + 1), 40));
          break;
        default:
          for (std::size_t i = at; i < at + length; ++i) text[i] = *rc::gen::arbitrary<char>();
      }
    }
    expect_clear_end(text);
  }
}

RC_GTEST_PROP(YamlReader, EndsClearlyOnAnyBytes, (std::string bytes)) { expect_clear_end(bytes); }

class YamlReaderFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(::testing::TempDir()) / fmt::format("headway_yaml_{}", info->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string load_complaint(const std::filesystem::path& file) {
    return complaint([&] { Section::load(file, "world"); });
  }

  std::filesystem::path folder_;
};

TEST_F(YamlReaderFiles, TellsAMissingFileFromAFolder) {
  const std::string name = (folder_ / "absent.yaml").string();
  EXPECT_EQ(load_complaint(name), name + ": no such world file; check the path");
  EXPECT_EQ(load_complaint(folder_), folder_.string() + ": is a folder, expected a world file");
  EXPECT_EQ(load_complaint("/dev/null"), "/dev/null: is a device or a pipe, expected a world file");
  std::filesystem::create_symlink("circle", folder_ / "circle");
  EXPECT_EQ(load_complaint(folder_ / "circle"),
            (folder_ / "circle").string() +
                ": cannot be read (Too many levels of symbolic links); check the path and its permissions");
}

TEST_F(YamlReaderFiles, RefusesAHugeFileWithoutReadingIt) {
  const auto file = folder_ / "huge.yaml";
  std::ofstream(file) << "a: 1\n";
  std::filesystem::resize_file(file, std::uintmax_t{1} << 40);
  EXPECT_THAT(load_complaint(file), HasSubstr("expected at most 1048576 in a world file"));
}

TEST_F(YamlReaderFiles, TakesPathsFromTheFilesOwnFolder) {
  const auto file = folder_ / "world.yaml";
  std::ofstream(file) << "near: rig.yaml\nfar: /etc/rig.yaml\nbad: \"a\\nb\"\n";
  const Section s = Section::load(file, "world");
  EXPECT_EQ(s.path("near"), folder_ / "rig.yaml");
  EXPECT_EQ(s.path("far"), "/etc/rig.yaml");
  EXPECT_THAT(complaint([&] { s.path("bad"); }), HasSubstr("expected a path"));
}

}  // namespace
}  // namespace headway::config
