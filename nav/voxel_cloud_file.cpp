#include "nav/voxel_cloud_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <ostream>
#include <sstream>
#include <vector>

#include <fmt/format.h>

#include "nav/byte_reader.h"
#include "nav/little_endian.h"
#include "nav/octree_leaves.h"
#include "nav/whole_file.h"

namespace headway::nav {
namespace {

constexpr int kMostHeaderLines = 1000;
constexpr const char* kResolution = "resolution";

enum class Kind : std::uint8_t { kSigned, kUnsigned, kFloating };

struct Type {
  const char *name, *other_name;
  unsigned size;
  Kind kind;
};
constexpr std::array<Type, 8> kTypes{{{"char", "int8", 1, Kind::kSigned},
                                      {"uchar", "uint8", 1, Kind::kUnsigned},
                                      {"short", "int16", 2, Kind::kSigned},
                                      {"ushort", "uint16", 2, Kind::kUnsigned},
                                      {"int", "int32", 4, Kind::kSigned},
                                      {"uint", "uint32", 4, Kind::kUnsigned},
                                      {"float", "float32", 4, Kind::kFloating},
                                      {"double", "float64", 8, Kind::kFloating}}};

double number_of(std::uint64_t bits, const Type& type) {
  if (type.kind == Kind::kFloating) {
    return type.size == 8 ? std::bit_cast<double>(bits)
                          : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
  }
  const unsigned unused = 64 - 8 * type.size;
  if (type.kind == Kind::kUnsigned) return static_cast<double>(bits);
  return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

struct Property {
  std::string name;
  Type type;
};

struct Header {
  enum class Format : std::uint8_t { kNone, kText, kLittleEndian, kBigEndian };
  Format format = Format::kNone;
  std::uint64_t points = 0;
  std::vector<Property> properties;  ///< of the points
  std::optional<double> resolution;

  std::optional<std::size_t> find(const char* name) const {
    for (std::size_t i = 0; i < properties.size(); ++i) {
      if (properties[i].name == name) return i;
    }
    return {};
  }
};

class HeaderReader {
 public:
  explicit HeaderReader(ByteReader& in) : in_(in) {}

  Header read() {
    if (in_.at_end() || in_.line() != "ply") in_.fail("expected 'ply' in the first line");
    for (int n = 0; n < kMostHeaderLines; ++n) {
      const std::string line = in_.line();
      if (line == "end_header") return whole();
      std::istringstream words(line);
      take(words, line);
    }
    in_.fail("the header does not end; expected a line 'end_header'");
  }

 private:
  void take(std::istringstream& words, const std::string& line) {
    std::string key, first, second;
    words >> key >> first >> second;
    if (key == "format") {
      header_.format = format(first);
    } else if (key == "comment" && first == kResolution) {
      double value = 0;  // others may speak of another resolution in words
      if (parse_number(second, value)) header_.resolution = value;
    } else if (key == "element") {
      if (++elements_ == 1 && (first != "vertex" || !parse_number(second, header_.points))) {
        in_.fail("'" + line + "': expected 'element vertex' and the number of points as the first element");
      }
    } else if (key == "property" && elements_ == 1) {
      header_.properties.push_back({second, type(first, line)});
    }
  }

  Header::Format format(const std::string& name) const {
    if (name == "ascii") return Header::Format::kText;
    if (name == "binary_little_endian") return Header::Format::kLittleEndian;
    if (name == "binary_big_endian") return Header::Format::kBigEndian;
    in_.fail("format: '" + name + "', expected ascii, binary_little_endian or binary_big_endian");
  }

  Type type(const std::string& name, const std::string& line) const {
    for (const Type& t : kTypes) {
      if (name == t.name || name == t.other_name) return t;
    }
    in_.fail("'" + line + "': expected a property of type char to double");
  }

  Header whole() const {
    if (header_.format == Header::Format::kNone) in_.fail("the header names no format");
    for (const char* name : {"x", "y", "z"}) {
      if (!header_.find(name)) in_.fail(fmt::format("its points have no '{}', expected x, y and z", name));
    }
    return header_;
  }

  ByteReader& in_;
  Header header_;
  int elements_ = 0;
};

/// The points one after the other: a number for each property.
class PointReader {
 public:
  PointReader(ByteReader& in, const Header& header)
      : in_(in), header_(header), row_(header.properties.size()) {}

  const std::vector<double>& next() {
    for (std::size_t i = 0; i < row_.size(); ++i) {
      row_[i] =
          header_.format == Header::Format::kText ? from_text() : from_bytes(header_.properties[i].type);
    }
    return row_;
  }

 private:
  double from_text() {
    const std::string word = in_.token();
    double value = 0;
    if (!parse_number(word, value)) in_.fail("'" + word + "', expected a number");
    return value;
  }

  double from_bytes(const Type& type) {
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < type.size; ++i) {
      const std::uint64_t b = in_.byte();
      bits = header_.format == Header::Format::kLittleEndian ? bits | b << (8 * i) : bits << 8 | b;
    }
    return number_of(bits, type);
  }

  ByteReader& in_;
  const Header& header_;
  std::vector<double> row_;
};

/// Puts points into voxels.
class Gatherer {
 public:
  Gatherer(ByteReader& in, double resolution, std::size_t most_bricks)
      : in_(in), map_(resolution), most_bricks_(most_bricks) {}

  /// `log_odds` is not finite where the point has none.
  void add(const std::array<double, 3>& point, double log_odds) {
    std::array<std::int32_t, 3> key{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (!std::isfinite(point[k])) return;
      const double along = std::floor(point[k] / map_.resolution());
      if (!(std::abs(along + 0.5) < kBrickReach * kBrickEdge)) {
        in_.fail(fmt::format("a point at {} m lies beyond the reach of a map, {} m at this resolution",
                             point[k], kBrickReach * kBrickEdge * map_.resolution()));
      }
      key[k] = static_cast<std::int32_t>(along);
    }
    LogOdds& voxel =
        map_.edit({key[0] >> 3, key[1] >> 3,
                   key[2] >> 3})[static_cast<std::size_t>(in_brick(key[0] & 7, key[1] & 7, key[2] & 7))];
    if (map_.size() > most_bricks_) {
      in_.fail(fmt::format(
          "holds more than {} bricks of 8 x 8 x 8 voxels, the most that one map may have; make its "
          "voxels larger",
          most_bricks_));
    }
    voxel = std::isfinite(log_odds) ? std::max(voxel, units_of(log_odds, log_odds >= 0)) : hit(voxel);
  }

  ColdMap take() && { return std::move(map_); }

 private:
  static LogOdds hit(LogOdds before) {
    const int known = before == log_odds::kUnseen ? 0 : before;
    return static_cast<LogOdds>(std::min<int>(known + log_odds::kHit, log_odds::kHighest));
  }

  ByteReader& in_;
  ColdMap map_;
  std::size_t most_bricks_;
};

double resolution_of(const Header& header, std::optional<double> wanted, const ByteReader& in) {
  const std::optional<double> resolution = wanted ? wanted : header.resolution;
  if (!resolution) in.fail("says nothing of voxels; the resolution of the map must be given");
  if (!(*resolution >= ColdMap::kFinest && *resolution <= ColdMap::kCoarsest)) {
    in.fail(fmt::format("resolution: {} m, expected {} to {} m", *resolution, ColdMap::kFinest,
                        ColdMap::kCoarsest));
  }
  return *resolution;
}

/// Calls visit(x, y, z [m], value) for each occupied voxel.
template <class Visit>
void for_each_occupied(const SeenBricks& map, Visit&& visit) {
  for (const PlacedBrick& brick : map.bricks()) {
    const BrickKey key = brick_at(brick.order);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const LogOdds value = brick.values[static_cast<std::size_t>(i)];
      if (value < log_odds::kOccupied) continue;
      const VoxelOfBrick in = voxel_of_brick(i);
      const auto middle = [&](std::int32_t k, int v) {
        return static_cast<float>((kBrickEdge * k + v + 0.5) * map.resolution());
      };
      visit(middle(key.x, in.x), middle(key.y, in.y), middle(key.z, in.z), value);
    }
  }
}

}  // namespace

void write_voxel_cloud(const SeenBricks& map, std::ostream& out) {
  std::size_t points = 0;
  for_each_occupied(map, [&](float, float, float, LogOdds) { ++points; });
  out << fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment middles of occupied voxels, map frame, metres\n"
      "comment {} {}\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property float log_odds\nend_header\n",
      kResolution, map.resolution(), points);
  for_each_occupied(map, [&](float x, float y, float z, LogOdds value) {
    const auto log_odds = static_cast<float>(value * log_odds::kUnit);
    for (const float number : {x, y, z, log_odds}) out << little_endian(number).text();
  });
}

void write_voxel_cloud(const SeenBricks& map, const std::filesystem::path& file) {
  write_whole(file, [&](std::ostream& out) { write_voxel_cloud(map, out); });
}

ColdMap read_voxel_cloud(std::istream& stream, const std::string& file, std::optional<double> resolution,
                         std::size_t most_bricks) {
  ByteReader in(stream, file);
  const Header header = HeaderReader(in).read();
  Gatherer voxels(in, resolution_of(header, resolution, in), most_bricks);
  PointReader points(in, header);
  const std::size_t x = *header.find("x"), y = *header.find("y"), z = *header.find("z");
  const auto log_odds = header.find("log_odds");
  for (std::uint64_t i = 0; i < header.points; ++i) {
    const std::vector<double>& row = points.next();
    voxels.add({row[x], row[y], row[z]},
               log_odds ? row[*log_odds] : std::numeric_limits<double>::quiet_NaN());
  }
  return std::move(voxels).take();
}

ColdMap read_voxel_cloud(const std::filesystem::path& file, std::optional<double> resolution,
                         std::size_t most_bricks) {
  std::ifstream in = open_whole(file);
  return read_voxel_cloud(in, file.string(), resolution, most_bricks);
}

}  // namespace headway::nav
