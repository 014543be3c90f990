#include "nav/moving_ai_file.h"

#include <algorithm>
#include <charconv>
#include <istream>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "hal/error.h"
#include "nav/whole_file.h"

namespace headway::nav {

namespace {

constexpr int kWidest = 32768;
constexpr std::size_t kMostCells = 100'000'000;  // 1 GB, with the time when each was seen

/// Line by line, and names them in complaints.
class Lines {
 public:
  Lines(std::istream& in, const std::string& file) : in_(in), file_(file) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", file_, number_, what));
  }

  std::string_view next(const std::string& expected) {
    ++number_;
    if (!std::getline(in_, line_)) fail("the file ends, expected " + expected);
    if (!line_.empty() && line_.back() == '\r') line_.pop_back();
    return line_;
  }

  void word(const std::string& expected) {
    if (next(fmt::format("'{}'", expected)) != expected)
      fail(fmt::format("expected '{}', as a Moving AI map has it", expected));
  }

  int number(const std::string& key) {
    const std::string wanted = fmt::format("'{} N', N from 1 to {}", key, kWidest);
    const std::string_view line = next(wanted);
    int value = 0;
    if (!line.starts_with(key + " ")) fail("expected " + wanted);
    const std::string_view digits = line.substr(key.size() + 1);
    const auto [end, error] = std::from_chars(digits.begin(), digits.end(), value);
    if (error != std::errc{} || end != digits.end() || value < 1 || value > kWidest)
      fail("expected " + wanted);
    return value;
  }

 private:
  std::istream& in_;
  const std::string& file_;
  std::string line_;
  int number_ = 0;
};

Floor terrain(char symbol, int column, const Lines& lines) {
  switch (symbol) {
    case '.':
    case 'G':
    case 'S':
      return Floor::kFree;
    case '@':
    case 'O':
    case 'T':
    case 'W':
      return Floor::kBlocked;
    default:
      lines.fail(fmt::format("column {}: unknown terrain, expected one of . G S @ O T W", column + 1));
  }
}

}  // namespace

FloorMap read_moving_ai(std::istream& text, const std::string& file, double resolution, Time stamp) {
  Lines lines(text, file);
  lines.word("type octile");
  const int height = lines.number("height"), width = lines.number("width");
  if (static_cast<std::size_t>(width) * static_cast<std::size_t>(height) > kMostCells)
    lines.fail(fmt::format("{} x {} cells are more than the {} that are read", width, height, kMostCells));
  lines.word("map");
  // Rows come from the top. No more memory is asked for than the file has rows.
  std::vector<Floor> cells;
  for (int row = 0; row < height; ++row) {
    const std::string_view line = lines.next(fmt::format("{} rows", height));
    if (line.size() != static_cast<std::size_t>(width))
      lines.fail(fmt::format("has {} columns, expected {}", line.size(), width));
    for (int x = 0; x < width; ++x) cells.push_back(terrain(line[static_cast<std::size_t>(x)], x, lines));
  }
  FloorMap floor = unseen_floor({resolution, {0, 0}, width, height});
  for (std::size_t y = 0, w = static_cast<std::size_t>(width); y < static_cast<std::size_t>(height); ++y)
    std::copy_n(cells.end() - static_cast<std::ptrdiff_t>((y + 1) * w), w,
                floor.cells.begin() + static_cast<std::ptrdiff_t>(y * w));
  std::fill(floor.seen_at.begin(), floor.seen_at.end(), stamp);
  return floor;
}

FloorMap read_moving_ai(const std::filesystem::path& file, double resolution, Time stamp) {
  std::ifstream in = open_whole(file);
  return read_moving_ai(in, file.string(), resolution, stamp);
}

}  // namespace headway::nav
