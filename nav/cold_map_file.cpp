#include "nav/cold_map_file.h"

#include <array>
#include <bit>
#include <ostream>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "nav/byte_reader.h"
#include "nav/checksum.h"
#include "nav/little_endian.h"
#include "nav/whole_file.h"

namespace headway::nav {
namespace {

constexpr std::string_view kMagic = "headway map ";
constexpr std::uint64_t kOldestVersion = 1, kFirstWithSurfaces = 2, kFirstWithRays = 3;
constexpr std::uint64_t kPlaces = std::uint64_t{1} << 3 * kLevelsAboveBrick;

/// Writes and sums up.
class Writer {
 public:
  explicit Writer(std::ostream& out) : out_(out) {}
  void bytes(std::string_view text) {
    sum_.add(text);
    out_.write(text.data(), static_cast<std::streamsize>(text.size()));
  }
  void sum() { bytes(LittleEndian<4>(sum_.value()).text()); }

 private:
  std::ostream& out_;
  Checksum sum_;
};

/// Reads and sums up.
class Reader {
 public:
  Reader(std::istream& in, const std::string& file) : in_(in, file) {}
  [[noreturn]] void fail(const std::string& what) const { in_.fail(what); }
  [[noreturn]] void damaged(const std::string& what) const {
    fail("is damaged (" + what + "); copy it again");
  }

  std::string line() {
    std::string text = in_.line();
    sum_.add(text + '\n');
    return text;
  }
  std::uint64_t number(unsigned size = 8) {
    std::array<char, 8> text{};
    bytes(text.data(), size);
    std::uint64_t value = 0;
    for (unsigned i = 0; i < size; ++i) {
      value |= static_cast<std::uint64_t>(static_cast<std::uint8_t>(text[i])) << (8 * i);
    }
    return value;
  }
  void bytes(char* into, std::size_t size) {
    in_.bytes(into, size);
    sum_.add({into, size});
  }
  void check_sum() {
    const std::uint32_t sum = sum_.value();
    if (number(4) != sum) damaged("its checksum is another");
    if (!in_.at_end()) damaged("something follows its end");
  }

 private:
  ByteReader in_;
  Checksum sum_;
};

/// Throws unless the version is one that is read.
std::uint64_t read_version(Reader& in) {
  const std::string line = in.line();
  std::uint64_t version = 0;
  if (!line.starts_with(kMagic) || !parse_number(line.substr(kMagic.size()), version)) {
    in.fail(fmt::format("expected '{}{}' in the first line; is this a map of Headway's?", kMagic,
                        kMapFileVersion));
  }
  if (version >= kOldestVersion && version <= kMapFileVersion) return version;
  const char* age = version > kMapFileVersion ? "a newer" : "an older";
  in.fail(fmt::format(
      "is a map of version {}, and this program reads versions {} to {}; let {} Headway, which wrote it, "
      "turn it into .ot ('headway map convert'), which every version reads",
      version, kOldestVersion, kMapFileVersion, age));
}

ColdMap read_bricks(Reader& in, std::size_t most_bricks) {
  const auto resolution = std::bit_cast<double>(in.number());
  if (!(resolution >= ColdMap::kFinest && resolution <= ColdMap::kCoarsest)) {
    in.damaged(fmt::format("a resolution of {} m", resolution));
  }
  const std::uint64_t bricks = in.number();
  if (bricks > most_bricks) {
    in.fail(fmt::format("claims {} bricks of 8 x 8 x 8 voxels, more than the {} that one map may have",
                        bricks, most_bricks));
  }
  ColdMap map(resolution);
  std::uint64_t next = 0;
  for (std::uint64_t b = 0; b < bricks; ++b) {
    const std::uint64_t order = in.number();
    if (order < next || order >= kPlaces) in.damaged("its bricks are out of order");
    next = order + 1;
    BrickValues values;
    in.bytes(reinterpret_cast<char*>(values.data()), values.size());
    map.put(brick_at(order), values);
  }
  return map;
}

template <std::size_t kCount>
void read_floats(Reader& in, std::array<float, kCount>& into) {
  for (float& f : into) f = std::bit_cast<float>(static_cast<std::uint32_t>(in.number(4)));
}

void read_surfaces(Reader& in, std::uint64_t version, SurfacePoints& surfaces) {
  std::uint64_t before = 0;
  const std::uint64_t voxels = in.number();
  for (std::uint64_t i = 0; i < voxels; ++i) {
    SurfaceVoxel voxel;
    voxel.key = in.number();
    if (voxel.key <= before) in.damaged("its surfaces are out of order");
    before = voxel.key;
    std::array<float, 3> sums{};
    read_floats(in, sums);
    voxel.weight = sums[0], voxel.count = sums[1], voxel.doubt = sums[2];
    read_floats(in, voxel.first);
    read_floats(in, voxel.second);
    if (version >= kFirstWithRays) read_floats(in, voxel.rays);
    if (!surfaces.restore(voxel)) in.damaged("a surface that cannot be, or one too many");
  }
}

}  // namespace

void write_map_file(const SeenBricks& map, const SurfacePoints& surfaces, std::ostream& out) {
  Writer file(out);
  file.bytes(fmt::format("{}{}\n", kMagic, kMapFileVersion));
  file.bytes(little_endian(map.resolution()).text());
  file.bytes(LittleEndian<8>(map.bricks().size()).text());
  for (const PlacedBrick& brick : map.bricks()) {
    file.bytes(LittleEndian<8>(brick.order).text());
    file.bytes({reinterpret_cast<const char*>(brick.values.data()), brick.values.size()});
  }
  const std::vector<SurfaceVoxel> voxels = surfaces.saved();
  file.bytes(LittleEndian<8>(voxels.size()).text());
  for (const SurfaceVoxel& voxel : voxels) {
    file.bytes(LittleEndian<8>(voxel.key).text());
    for (const float f : {voxel.weight, voxel.count, voxel.doubt}) file.bytes(little_endian(f).text());
    for (const float f : voxel.first) file.bytes(little_endian(f).text());
    for (const float f : voxel.second) file.bytes(little_endian(f).text());
    for (const float f : voxel.rays) file.bytes(little_endian(f).text());
  }
  file.sum();
}

void write_map_file(const SeenBricks& map, std::ostream& out) {
  write_map_file(map, SurfacePoints(map.resolution()), out);
}

SavedMap read_saved_map(std::istream& stream, const std::string& file, std::size_t most_bricks) {
  Reader in(stream, file);
  const std::uint64_t version = read_version(in);
  SavedMap saved(read_bricks(in, most_bricks));
  if (version >= kFirstWithSurfaces) read_surfaces(in, version, saved.surfaces);
  in.check_sum();
  return saved;
}

SavedMap read_saved_map(const std::filesystem::path& file, std::size_t most_bricks) {
  std::ifstream in = open_whole(file);
  return read_saved_map(in, file.string(), most_bricks);
}

ColdMap read_map_file(std::istream& stream, const std::string& file, std::size_t most_bricks) {
  return read_saved_map(stream, file, most_bricks).map;
}

ColdMap read_map_file(const std::filesystem::path& file, std::size_t most_bricks) {
  return read_saved_map(file, most_bricks).map;
}

}  // namespace headway::nav
