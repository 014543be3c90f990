#include "bench/planning_floors.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include <zlib.h>

#include "hal/error.h"

namespace headway::bench {

namespace {

namespace fs = std::filesystem;

std::string whole_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(path.string() + ": cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The first file of a zip archive (PKWARE's APPNOTE 4.3.7), deflated, its length in the header.
std::string first_of_zip(const fs::path& path) {
  const std::string zip = whole_file(path);
  const auto number = [&](std::size_t at, std::size_t bytes) {
    std::size_t value = 0;
    for (std::size_t i = bytes; i-- > 0;) value = value << 8 | static_cast<unsigned char>(zip[at + i]);
    return value;
  };
  constexpr std::size_t kHeader = 30;
  const auto malformed = [&] { return Error(path.string() + ": is no zip archive of one deflated file"); };
  if (zip.size() < kHeader || std::memcmp(zip.data(), "PK\3\4", 4) != 0 || number(8, 2) != Z_DEFLATED)
    throw malformed();
  const std::size_t begin = kHeader + number(26, 2) + number(28, 2);
  if (begin >= zip.size()) throw malformed();
  std::string text(number(22, 4), '\0');
  std::string data = zip.substr(begin);
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(data.data());
  stream.avail_in = static_cast<uInt>(data.size());
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = static_cast<uInt>(text.size());
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) throw malformed();
  const int result = inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  if (result != Z_STREAM_END) throw malformed();
  return text;
}

}  // namespace

nav::FloorMap read_floor(const std::string& name) {
  const char* data = std::getenv("HEADWAY_DATA");
  if (data == nullptr) throw Error("HEADWAY_DATA is not set: no floors to plan on");
  const fs::path maps = fs::path(data) / "maps";
  const fs::path plain = maps / (name + ".cfg");
  std::istringstream in(fs::exists(plain) ? whole_file(plain) : first_of_zip(maps / (name + ".zip")));
  int width = 0, height = 0, threshold = 0;
  double size = 0;
  for (std::string key; in >> key && key != "environment:";) {
    if (key == "discretization(cells):") in >> width >> height;
    if (key == "obsthresh:") in >> threshold;
    if (key == "cellsize(meters):") in >> size;
  }
  nav::FloorGrid grid;
  grid.width = (width + 1) / 2;
  grid.height = (height + 1) / 2;
  grid.resolution = 2 * size;
  nav::FloorMap map = nav::unseen_floor(grid);
  map.cells.assign(grid.size(), nav::Floor::kFree);
  for (int y = 0; y < height; ++y) {
    for (int x = 0, cost = 0; x < width; ++x) {
      if (!(in >> cost)) throw Error(name + ": ends in row " + std::to_string(y));
      if (cost >= threshold) map.cells[grid.index({x / 2, y / 2})] = nav::Floor::kBlocked;
    }
  }
  return map;
}

}  // namespace headway::bench
