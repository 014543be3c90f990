// The images of two cameras, by pairs, from the paths that a user names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace headway::app {

struct ImagePair {
  std::string name;  ///< what both files' names have in common: "01" of left01.jpg and right01.jpg
  std::filesystem::path left, right;
};

/// In the order of their names. The paths are one of:
///   a folder with left*.EXT and right*.EXT, or with folders left and right, or cam0/data and cam1/data
///   (EuRoC); two folders, or two patterns of file names (* and ?), the left camera's first; image files,
///   called left... and right....
/// Images belong together when their names agree, left and right apart. Throws InputError for what is
/// missing: a folder, any image at all, the partner of one.
std::vector<ImagePair> find_image_pairs(const std::vector<std::string>& paths);

/// The images of one camera that lie in a folder, by name.
std::vector<std::filesystem::path> images_in(const std::filesystem::path& folder);

}  // namespace headway::app
