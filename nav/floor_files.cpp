#include "nav/floor_files.h"

#include <fstream>
#include <limits>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "config/yaml_reader.h"
#include "hal/error.h"
#include "nav/whole_file.h"

namespace headway::nav {
namespace {

namespace fs = std::filesystem;

constexpr std::uint8_t kPgmOccupied = 0, kPgmFree = 254, kPgmUnknown = 205;
constexpr double kOccupiedThreshold = 0.65, kFreeThreshold = 0.196;  // 205 lies between them
constexpr int kWidest = 32768;

/// 8-bit grey values, row 0 on top, as files have them.
struct Pgm {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

std::uint8_t pgm_value(Floor f) {
  return f == Floor::kBlocked ? kPgmOccupied : f == Floor::kFree ? kPgmFree : kPgmUnknown;
}

/// Goes through the bytes of a PGM file and names it in complaints.
class PgmReader {
 public:
  explicit PgmReader(const fs::path& file) : file_(file), in_(file, std::ios::binary) {
    std::error_code error;
    if (!fs::is_regular_file(file, error) || !in_) {
      throw InputError(fmt::format("{}: no such image; the map's 'image' names it", file.string()));
    }
  }

  Pgm read() {
    std::string magic(2, ' ');
    in_.read(magic.data(), 2);
    if (magic != "P5" && magic != "P2") fail("no PGM image, expected the magic number P5 or P2");
    Pgm pgm;
    pgm.width = number("width", 1, kWidest);
    pgm.height = number("height", 1, kWidest);
    if (number("largest value", 1, 65535) != 255) fail("largest value is not 255, expected an 8-bit image");
    const auto count = static_cast<std::size_t>(pgm.width) * static_cast<std::size_t>(pgm.height);
    if (fs::file_size(file_) < count) {  // before so much memory is asked for
      fail(fmt::format("is too short for {} x {} pixels; copy it again", pgm.width, pgm.height));
    }
    pgm.pixels.resize(count);
    if (magic == "P2") {
      for (auto& p : pgm.pixels) p = static_cast<std::uint8_t>(number("pixel", 0, 255));
      return pgm;
    }
    in_.get();
    in_.read(reinterpret_cast<char*>(pgm.pixels.data()), static_cast<std::streamsize>(pgm.pixels.size()));
    if (static_cast<std::size_t>(in_.gcount()) != pgm.pixels.size()) {
      fail(fmt::format("ends after {} of {} pixels; copy it again", in_.gcount(), pgm.pixels.size()));
    }
    return pgm;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(file_.string() + ": " + what); }

  /// The next decimal number after white space and comments.
  int number(const char* name, int lowest, int highest) {
    while (in_ && (std::isspace(in_.peek()) || in_.peek() == '#')) {
      if (in_.get() == '#') in_.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    int value = -1;
    if (!std::isdigit(in_.peek()) || !(in_ >> value) || value < lowest || value > highest) {
      fail(fmt::format("{}: expected a whole number from {} to {}", name, lowest, highest));
    }
    return value;
  }

  fs::path file_;
  std::ifstream in_;
};

}  // namespace

void write_map_server(const FloorMap& floor, const fs::path& folder) {
  const FloorGrid& grid = floor.grid;
  write_whole(folder / "floor.pgm", [&](std::ostream& out) {
    out << "P5\n" << grid.width << ' ' << grid.height << "\n255\n";
    for (int y = grid.height - 1; y >= 0; --y) {
      for (int x = 0; x < grid.width; ++x)
        out.put(static_cast<char>(pgm_value(floor.cells[grid.index({x, y})])));
    }
  });
  write_whole(folder / "floor.yaml", [&](std::ostream& out) {
    out << fmt::format(
        "image: floor.pgm\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\noccupied_thresh: {}\nfree_thresh: "
        "{}\n",
        grid.resolution, grid.origin.x(), grid.origin.y(), kOccupiedThreshold, kFreeThreshold);
  });
}

FloorMap read_map_server(const fs::path& yaml, Time stamp) {
  const auto file = config::Section::load(yaml, "floor map");
  const fs::path image = file.path("image");
  const double resolution = file.number("resolution", {0.001, 10, "m"});
  const auto origin = file.numbers("origin", 3, {-1e6, 1e6, "m (x, y) and rad (yaw, 0)"});
  if (origin[2] != 0) file.fail("origin", "a turned map is not read, expected yaw 0; turn the image instead");
  const bool negate = file.integer_or("negate", 0, {0, 1}) == 1;
  const double occupied = file.number("occupied_thresh", {0, 1}), free = file.number("free_thresh", {0, 1});
  if (free >= occupied) file.fail("free_thresh", "expected less than occupied_thresh");
  file.choice_or("mode", "trinary", {"trinary"});
  file.finish();

  const Pgm pgm = PgmReader(image).read();
  FloorMap floor = unseen_floor({resolution, {origin[0], origin[1]}, pgm.width, pgm.height});
  for (std::size_t i = 0; i < floor.cells.size(); ++i) {
    const auto width = static_cast<std::size_t>(pgm.width), height = static_cast<std::size_t>(pgm.height);
    const std::uint8_t grey = pgm.pixels[(height - 1 - i / width) * width + i % width];
    const double p = (negate ? grey : 255 - grey) / 255.0;
    if (p > occupied) floor.cells[i] = Floor::kBlocked;
    if (p < free) floor.cells[i] = Floor::kFree;
    if (floor.cells[i] != Floor::kUnseen) floor.seen_at[i] = stamp;
  }
  return floor;
}

}  // namespace headway::nav
