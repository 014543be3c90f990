#include "app/image_pairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/error.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

using testing::HasSubstr;

/// "name:left|right" of each pair, the files' names alone.
std::vector<std::string> pairs_of(const std::vector<std::string>& paths) {
  std::vector<std::string> out;
  for (const ImagePair& p : find_image_pairs(paths))
    out.push_back(p.name + ":" + p.left.filename().string() + "|" + p.right.filename().string());
  return out;
}

std::string message_of(const std::vector<std::string>& paths) {
  try {
    find_image_pairs(paths);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

class ImagePairs : public testing::Test {
 protected:
  /// Empty files: only names count here.
  std::string put(const std::string& name) {
    write_text(folder_ / name, "");
    return (folder_ / name).string();
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  TemporaryFolder folder_;
};

TEST_F(ImagePairs, AreFoundInOneFolderByTheirNames) {
  for (const char* name :
       {"left02.jpg", "right01.jpg", "left01.jpg", "Right02.jpg", "notes.txt", "other.png"})
    put(name);
  EXPECT_THAT(pairs_of({at("")}),
              testing::ElementsAre("01:left01.jpg|right01.jpg", "02:left02.jpg|Right02.jpg"));
}

TEST_F(ImagePairs, AreFoundInFoldersOfEachCamera) {
  for (const char* name : {"a/left/5.png", "a/right/5.png", "b/cam0/data/7.png", "b/cam1/data/7.png"})
    put(name);
  EXPECT_THAT(pairs_of({at("a")}), testing::ElementsAre("5:5.png|5.png"));
  EXPECT_THAT(pairs_of({at("b")}), testing::ElementsAre("7:7.png|7.png"));
  EXPECT_THAT(pairs_of({at("a/left"), at("a/right")}), testing::ElementsAre("5:5.png|5.png"));
}

TEST_F(ImagePairs, AreFoundByPatternsAndAsFiles) {
  std::vector<std::string> files;
  for (const char* name : {"left1.png", "left2.png", "right1.png", "right2.png"}) files.push_back(put(name));
  put("left10.png");
  const auto both = testing::ElementsAre("1:left1.png|right1.png", "2:left2.png|right2.png");
  EXPECT_THAT(pairs_of({at("left?.png"), at("right*.png")}), both);
  EXPECT_THAT(pairs_of(files), both);
}

TEST_F(ImagePairs, SayWhatIsMissing) {
  EXPECT_THAT(message_of({}), HasSubstr("expected a folder"));
  EXPECT_THAT(message_of({at("none")}), HasSubstr("none: expected one folder, two folders"));
  EXPECT_THAT(message_of({at("none/l*"), at("none/r*")}), HasSubstr("none: no such folder"));
  put("left1.png"), put("right1.png"), put("left2.png");
  EXPECT_THAT(message_of({at("")}),
              HasSubstr("left2.png: has no partner for the right camera (2 left and 1 right images)"));
  EXPECT_THAT(message_of({at("x*"), at("r*")}), HasSubstr("x*: no image has such a name"));
  put("empty/notes.txt");
  EXPECT_THAT(message_of({at("empty")}), HasSubstr("empty: holds no images left"));
  EXPECT_THAT(message_of({at("left1.png"), at("empty")}), HasSubstr("empty: expected one folder"));
}

}  // namespace
}  // namespace headway::app
