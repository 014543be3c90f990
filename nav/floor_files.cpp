#include "nav/floor_files.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <ostream>
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
constexpr std::size_t kMostCells = 100'000'000;  // 1 GB, with the time when each was seen

/// 8-bit grey values, row 0 on top, as files have them.
struct Pgm {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

std::uint8_t pgm_value(Floor f) {
  return is_occupied(f) ? kPgmOccupied : f == Floor::kFree ? kPgmFree : kPgmUnknown;
}

/// Goes through the bytes of a PGM file and names it in complaints.
class PgmReader {
 public:
  PgmReader(std::istream& in, const std::string& file) : file_(file), in_(in) {}

  Pgm read() {
    std::string magic(2, ' ');
    in_.read(magic.data(), 2);
    if (magic != "P5" && magic != "P2") fail("no PGM image, expected the magic number P5 or P2");
    Pgm pgm;
    pgm.width = number("width", 1, kWidest);
    pgm.height = number("height", 1, kWidest);
    if (number("largest value", 1, 65535) != 255) fail("largest value is not 255, expected an 8-bit image");
    const auto count = static_cast<std::size_t>(pgm.width) * static_cast<std::size_t>(pgm.height);
    if (count > kMostCells) {
      fail(fmt::format("holds {} x {} pixels, more than the {} that are read", pgm.width, pgm.height,
                       kMostCells));
    }
    if (magic == "P5") in_.get();
    while (pgm.pixels.size() < count) {
      magic == "P2" ? pgm.pixels.push_back(static_cast<std::uint8_t>(number("pixel", 0, 255)))
                    : read_piece(pgm.pixels, count);
    }
    return pgm;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(file_ + ": " + what); }

  /// Piece by piece, so that no more memory is asked for than the file has pixels.
  void read_piece(std::vector<std::uint8_t>& pixels, std::size_t count) {
    constexpr std::size_t kPiece = 1 << 16;
    const std::size_t before = pixels.size(), wanted = std::min(kPiece, count - before);
    pixels.resize(before + wanted);
    in_.read(reinterpret_cast<char*>(pixels.data() + before), static_cast<std::streamsize>(wanted));
    const auto got = static_cast<std::size_t>(in_.gcount());
    if (got != wanted) fail(fmt::format("ends after {} of {} pixels; copy it again", before + got, count));
  }

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

  std::string file_;
  std::istream& in_;
};

/// What the YAML file says of the image.
struct MapServerYaml {
  fs::path image;
  double resolution, occupied, free;
  Eigen::Vector2d origin;
  bool negate;
};

MapServerYaml yaml_from(const config::Section& file) {
  MapServerYaml yaml;
  yaml.image = file.path("image");
  yaml.resolution = file.number("resolution", {0.001, 10, "m"});
  const auto origin = file.numbers("origin", 3, {-1e6, 1e6, "m (x, y) and rad (yaw, 0)"});
  if (origin[2] != 0) file.fail("origin", "a turned map is not read, expected yaw 0; turn the image instead");
  yaml.origin = {origin[0], origin[1]};
  yaml.negate = file.integer_or("negate", 0, {0, 1}) == 1;
  yaml.occupied = file.number("occupied_thresh", {0, 1});
  yaml.free = file.number("free_thresh", {0, 1});
  if (yaml.free >= yaml.occupied) file.fail("free_thresh", "expected less than occupied_thresh");
  file.choice_or("mode", "trinary", {"trinary"});
  file.finish();
  return yaml;
}

FloorMap floor_from(const MapServerYaml& yaml, const Pgm& pgm, Time stamp) {
  FloorMap floor = unseen_floor({yaml.resolution, yaml.origin, pgm.width, pgm.height});
  const auto width = static_cast<std::size_t>(pgm.width), height = static_cast<std::size_t>(pgm.height);
  for (std::size_t i = 0; i < floor.cells.size(); ++i) {
    const std::uint8_t grey = pgm.pixels[(height - 1 - i / width) * width + i % width];
    const double p = (yaml.negate ? grey : 255 - grey) / 255.0;
    if (p > yaml.occupied) floor.cells[i] = Floor::kBlocked;
    if (p < yaml.free) floor.cells[i] = Floor::kFree;
    if (floor.cells[i] != Floor::kUnseen) floor.seen_at[i] = stamp;
  }
  return floor;
}

/// As YAML has it: in quotes, unless nothing in it could mean anything else.
std::string yaml_text(const std::string& text) {
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-';
  };
  if (!text.empty() && std::ranges::all_of(text, plain) &&
      std::isalpha(static_cast<unsigned char>(text[0])) != 0)
    return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

}  // namespace

void write_map_server(const FloorMap& floor, const fs::path& folder, const std::string& name) {
  const FloorGrid& grid = floor.grid;
  const std::string image = name + ".pgm";
  const auto write_image = [&](std::ostream& out) {
    out << "P5\n" << grid.width << ' ' << grid.height << "\n255\n";
    for (int y = grid.height - 1; y >= 0; --y) {
      for (int x = 0; x < grid.width; ++x)
        out.put(static_cast<char>(pgm_value(floor.cells[grid.index({x, y})])));
    }
  };
  // The image takes its place while all of the other is on its way: both appear, or neither.
  write_whole(folder / (name + ".yaml"), [&](std::ostream& out) {
    out << fmt::format(
        "image: {}\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\noccupied_thresh: {}\nfree_thresh: "
        "{}\n",
        yaml_text(image), grid.resolution, grid.origin.x(), grid.origin.y(), kOccupiedThreshold,
        kFreeThreshold);
    if (out.flush()) write_whole(folder / image, write_image);
  });
}

FloorMap read_map_server(const fs::path& yaml, Time stamp) {
  const MapServerYaml file = yaml_from(config::Section::load(yaml, "floor map"));
  std::ifstream image = open_whole(file.image);
  return floor_from(file, PgmReader(image, file.image.string()).read(), stamp);
}

FloorMap read_map_server(const std::string& yaml, std::istream& image, const std::string& file, Time stamp) {
  const MapServerYaml text = yaml_from(config::Section::parse(yaml, file));
  return floor_from(text, PgmReader(image, text.image.string()).read(), stamp);
}

}  // namespace headway::nav
