// Any bytes as a map file: what fuzzers and mutation tests throw at the readers, and small whole files to
// begin with.
#pragma once

#include <array>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "hal/error.h"
#include "nav/cold_map_file.h"
#include "nav/floor_columns.h"
#include "nav/floor_files.h"
#include "nav/octomap_files.h"
#include "nav/voxel_cloud_file.h"
#include "tests/fuzz/old_map_files.h"

namespace headway::fuzz {

/// Bricks that a reader may make of one input: 8 MB.
inline constexpr std::size_t kMostBricks = 1 << 14;

using Reader = std::function<nav::SavedMap(const std::string& bytes)>;

/// YAML up to the first zero byte, and then the image.
inline nav::SavedMap read_floor(const std::string& bytes) {
  const std::size_t end = bytes.find('\0');
  std::istringstream image(end == std::string::npos ? "" : bytes.substr(end + 1));
  const nav::FloorMap floor = nav::read_map_server(bytes.substr(0, end), image, "floor.yaml");
  return nav::raise_floor(floor, 1.7, kMostBricks);
}

/// Every reader of maps; the first byte of an input chooses among them.
inline const std::array<Reader, 7>& readers() {
  const auto stream = [](auto read) {
    return Reader([read](const std::string& bytes) {
      std::istringstream in(bytes);
      return nav::SavedMap(read(in));
    });
  };
  static const std::array<Reader, 7> all{
      stream([](std::istream& in) { return nav::read_bt(in, "map.bt", kMostBricks); }),
      stream([](std::istream& in) { return nav::read_ot(in, "map.ot", kMostBricks); }),
      stream([](std::istream& in) { return nav::read_saved_map(in, "map.hmap", kMostBricks); }),
      stream([](std::istream& in) { return nav::read_voxel_cloud(in, "map.ply", {}, kMostBricks); }),
      stream([](std::istream& in) { return nav::read_voxel_cloud(in, "cloud.ply", 0.05, kMostBricks); }),
      read_floor,
      [](const std::string& bytes) {  // past the checksum, which hides all else
        std::istringstream in(with_sum(bytes));
        return nav::read_saved_map(in, "map.hmap", kMostBricks);
      },
  };
  return all;
}

/// True when the input is a map, false when it was refused with InputError; lets every other exception out.
/// Throws std::logic_error when the map is not whole: what it is written as must read as the same.
inline bool is_map(const std::string& input) {
  if (input.empty()) return false;
  const Reader& read = readers()[static_cast<unsigned char>(input[0]) % readers().size()];
  try {
    const nav::SavedMap saved = read(input.substr(1));
    std::stringstream file;
    nav::write_map_file(saved.map, saved.surfaces, file);
    const nav::SavedMap again = nav::read_saved_map(file, "again.hmap");
    if (!(again.map == saved.map && again.surfaces.saved() == saved.surfaces.saved()))
      throw std::logic_error("a map does not survive its file");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// At least one whole input for each reader.
inline std::vector<std::string> whole_inputs() {
  nav::ColdMap map(0.05);
  nav::BrickValues values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<nav::LogOdds>(i % 64 < 40 ? -8 : i % 64 < 50 ? 17 : -128);
  }
  map.put({0, -1, 2}, values);
  values.fill(nav::log_odds::kLowest);
  for (std::int32_t i = 0; i < 8; ++i) map.put({8 + i % 2, 8 + i / 2 % 2, 8 + i / 4}, values);
  std::array<std::ostringstream, 4> files;
  nav::write_bt(map, files[0]);
  nav::write_ot(map, files[1]);
  nav::SurfacePoints surfaces(map.resolution());
  for (std::uint64_t key = 1; key < 4; ++key)
    surfaces.restore({.key = key,
                      .weight = 1e4F,
                      .count = 2,
                      .doubt = 1e-6F,
                      .first = {},
                      .second = {},
                      .rays = {5e3F, 0, -5e3F}});
  nav::write_map_file(map, surfaces, files[2]);
  nav::write_voxel_cloud(map, files[3]);
  std::vector<std::string> inputs;
  for (std::size_t i = 0; i < files.size(); ++i) inputs.push_back(static_cast<char>(i) + files[i].str());
  inputs.push_back('\x02' + of_version_1(map));
  inputs.push_back('\x02' + of_version_2(map, surfaces));
  inputs.push_back(
      "\x04ply\nformat ascii 1.0\ncomment points\nelement vertex 2\nproperty double x\nproperty float y\n"
      "property short z\nproperty uchar red\nend_header\n0.1 -2 3 255\n1e0 nan 0 7\n");
  inputs.push_back(
      "\x05image: floor.pgm\nresolution: 0.05\norigin: [-1, 2, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
      "free_thresh: 0.196\n" +
      std::string("\0P5 # a comment\n4 3\n255\n", 24) +
      std::string("\0\0\0\0\xcd\xcd\xfe\xfe\xfe\xfe\xfe\xfe", 12));
  inputs.push_back('\x06' + inputs[2].substr(1, inputs[2].size() - 5));
  return inputs;
}

}  // namespace headway::fuzz
