#include "nav/cold_map_file.h"

#include <array>
#include <bit>
#include <ostream>
#include <string_view>

#include <fmt/format.h>

#include "nav/byte_reader.h"
#include "nav/checksum.h"
#include "nav/little_endian.h"
#include "nav/whole_file.h"

namespace headway::nav {
namespace {

constexpr std::string_view kMagic = "headway map ";
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

void check_version(Reader& in) {
  const std::string line = in.line();
  std::uint64_t version = 0;
  if (!line.starts_with(kMagic) || !parse_number(line.substr(kMagic.size()), version)) {
    in.fail(fmt::format("expected '{}{}' in the first line; is this a map of Headway's?", kMagic,
                        kMapFileVersion));
  }
  if (version == kMapFileVersion) return;
  const char* age = version > kMapFileVersion ? "a newer" : "an older";
  in.fail(fmt::format(
      "is a map of version {}, and this program reads version {}; let {} Headway, which wrote it, "
      "turn it into .ot ('headway map convert'), which every version reads",
      version, kMapFileVersion, age));
}

}  // namespace

void write_map_file(const SeenBricks& map, std::ostream& out) {
  Writer file(out);
  file.bytes(fmt::format("{}{}\n", kMagic, kMapFileVersion));
  file.bytes(little_endian(map.resolution()).text());
  file.bytes(LittleEndian<8>(map.bricks().size()).text());
  for (const PlacedBrick& brick : map.bricks()) {
    file.bytes(LittleEndian<8>(brick.order).text());
    file.bytes({reinterpret_cast<const char*>(brick.values.data()), brick.values.size()});
  }
  file.sum();
}

ColdMap read_map_file(std::istream& stream, const std::string& file, std::size_t most_bricks) {
  Reader in(stream, file);
  check_version(in);
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
  in.check_sum();
  return map;
}

ColdMap read_map_file(const std::filesystem::path& file, std::size_t most_bricks) {
  std::ifstream in = open_whole(file);
  return read_map_file(in, file.string(), most_bricks);
}

}  // namespace headway::nav
