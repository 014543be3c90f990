#include "nav/surveyed_floor.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>

namespace headway::nav {

using Eigen::Vector2i;

namespace {

constexpr int kNoCell = std::numeric_limits<int>::max();

/// Of the chunk at (y, i); nothing where it is the same.
std::optional<ChunkChange> change_of(int y, int i, const FloorChunk& before, const FloorChunk& now) {
  if (std::memcmp(&before, &now, sizeof now) == 0) return std::nullopt;
  unsigned raised = 0, lowered = 0;
  for (std::size_t slot = 0; slot < kConfigurations; ++slot) {
    raised |= now.blocked[slot] & ~unsigned{before.blocked[slot]};
    lowered |= before.blocked[slot] & ~unsigned{now.blocked[slot]};
  }
  for (std::size_t diagonal = 0; diagonal < 2; ++diagonal) {
    for (std::size_t cell = 0; cell < kChunkCells; ++cell) {
      const Ticks old = before.price[diagonal][cell], price = now.price[diagonal][cell];
      raised |= static_cast<unsigned>(price > old) << cell;
      lowered |= static_cast<unsigned>(price < old);
    }
  }
  return ChunkChange{y, i, static_cast<std::uint16_t>(raised), lowered != 0};
}

}  // namespace

const FloorChanges& SurveyedFloor::update(const FloorMap& map, const GroundView& view) {
  const bool other_size = chunks_.width() != map.grid.width || chunks_.height() != map.grid.height;
  if (other_size) chunks_.reset(map.grid.width, map.grid.height);
  changes_ = {other_size || raster_.width == 0, {}};
  if (changes_.everything)
    begin(map);
  else
    compare(map);
  const CellBox near = view.near_start();
  look_near(view, near_);
  look_near(view, near);
  near_ = near;
  rework();
  return changes_;
}

void SurveyedFloor::begin(const FloorMap& map) {
  const int width = map.grid.width, height = map.grid.height;
  map_ = map.cells;
  ground_.resize(map.cells.size());
  std::array<Ground, 4> grounds{};
  for (const Floor f : {Floor::kUnseen, Floor::kFree, Floor::kBlocked, Floor::kLow})
    grounds[static_cast<std::size_t>(f)] = ground_of(f, unseen_);
  std::transform(map_.begin(), map_.end(), ground_.begin(),
                 [&](Floor f) { return grounds[static_cast<std::size_t>(f)]; });
  raster_ = {width, height, ground_.data()};
  blocked_.reset(width, height, true);
  tight_.reset(width, height, false);
  low_.reset(width, height, false);
  tight_cells_ = 0;
  low_cells_ = static_cast<int>(std::count(ground_.begin(), ground_.end(), Ground::kLow));
  near_ = {};
  changed_.assign(static_cast<std::size_t>(height), {0, width - 1});
  for (int y = 0; y < height; ++y) {
    const Ground* row = raster_.row(y);
    blocked_.add_row(y, width, [row](int x) { return row[x] == Ground::kBlocked; });
    if (low_cells_ > 0) low_.add_row(y, width, [row](int x) { return row[x] == Ground::kLow; });
  }
}

void SurveyedFloor::compare(const FloorMap& map) {
  const auto width = static_cast<std::size_t>(raster_.width);
  for (int y = 0; y < raster_.height; ++y) {
    const std::size_t begin = static_cast<std::size_t>(y) * width;
    const Floor *now = map.cells.data() + begin, *old = map_.data() + begin;
    if (std::memcmp(now, old, width * sizeof(Floor)) == 0) continue;
    const auto first = std::mismatch(now, now + width, old).first - now;
    auto last = static_cast<std::ptrdiff_t>(width) - 1;
    while (now[last] == old[last]) --last;
    take_row(map, y, static_cast<int>(first), static_cast<int>(last));
  }
}

void SurveyedFloor::take_row(const FloorMap& map, int y, int first, int last) {
  const std::size_t begin = map.grid.index({0, y});
  for (int x = first; x <= last; ++x) {
    const std::size_t i = begin + static_cast<std::size_t>(x);
    map_[i] = map.cells[i];
    change(x, y, ground_of(map.cells[i], unseen_));
  }
}

void SurveyedFloor::change(int x, int y, Ground ground) {
  Ground& known = ground_[static_cast<std::size_t>(y) * static_cast<std::size_t>(raster_.width) +
                          static_cast<std::size_t>(x)];
  if (known == ground) return;
  tight_cells_ += (ground == Ground::kTight) - (known == Ground::kTight);
  low_cells_ += (ground == Ground::kLow) - (known == Ground::kLow);
  known = ground;
  blocked_.set(x, y, ground == Ground::kBlocked);
  tight_.set(x, y, ground == Ground::kTight);
  low_.set(x, y, ground == Ground::kLow);
  Span& row = changed_[static_cast<std::size_t>(y)];
  row = {std::min(row.first, x), std::max(row.last, x)};
}

void SurveyedFloor::look_near(const GroundView& view, const CellBox& box) {
  for (int y = box.low.y(); y <= box.high.y(); ++y)
    for (int x = box.low.x(); x <= box.high.x(); ++x) change(x, y, view.at({x, y}));
}

/// Changed rows that lie near each other are worked on together.
void SurveyedFloor::rework() {
  // As far apart as blocks of motions may be that both reach: those must be found once.
  const int apart = std::max(
      {32, dilation_.highest() - dilation_.lowest(), bare_dilation_.highest() - bare_dilation_.lowest()});
  CellBox box;
  const auto finish = [&] {
    if (box.high.y() >= 0) rework(box);
    box = CellBox{};
  };
  for (int y = 0; y < raster_.height; ++y) {
    Span& row = changed_[static_cast<std::size_t>(y)];
    if (row.first > row.last) continue;
    if (box.high.y() >= 0 && y > box.high.y() + apart) finish();
    if (box.high.y() < 0) box = {{row.first, y}, {row.last, y}};
    box.low.x() = std::min(box.low.x(), row.first);
    box.high = {std::max(box.high.x(), row.last), y};
    row = {kNoCell, -1};
  }
  finish();
}

void SurveyedFloor::rework(const CellBox& changed) {
  const int width = raster_.width, height = raster_.height;
  const auto column = [&](int x) { return std::clamp(x, 0, width - 1); };
  const auto row = [&](int y) { return std::clamp(y, 0, height - 1); };
  const int reach = std::max(dilation_.farthest(), bare_dilation_.farthest());
  const BlockRange range{row(changed.low.y() - std::max(dilation_.highest(), bare_dilation_.highest())),
                         row(changed.high.y() - std::min(dilation_.lowest(), bare_dilation_.lowest())),
                         column(changed.low.x() - reach) / kBlockCells,
                         column(changed.high.x() + reach) / kBlockCells};
  const int far = prices_.reach();
  const CellBox priced{{column(changed.low.x() - far) / kChunkCells, row(changed.low.y() - far)},
                       {column(changed.high.x() + far) / kChunkCells, row(changed.high.y() + far)}};
  const CellBox chunks{{std::min(priced.low.x(), column(changed.low.x() - reach) / kChunkCells),
                        std::min(priced.low.y(), range.first_row)},
                       {std::max(priced.high.x(), column(changed.high.x() + reach) / kChunkCells),
                        std::max(priced.high.y(), range.last_row)}};
  if (!changes_.everything) remember(chunks);
  dilation_.block(blocked_, range, chunks_);
  if (tight_cells_ > 0) bare_dilation_.block_more(tight_, range, chunks_);
  if (low_cells_ > 0) dilation_.block_more(low_, range, chunks_, false);
  prices_.compute(raster_, priced.low.y(), priced.high.y(), priced.low.x(), priced.high.x(), chunks_);
  if (low_cells_ > 0) price_low_ground(priced);
  if (!changes_.everything) list_changes(chunks);
}

void SurveyedFloor::price_low_ground(const CellBox& chunks) {
  const int first = chunks.low.x() * kChunkCells,
            end = std::min(raster_.width, (chunks.high.x() + 1) * kChunkCells);
  for (int y = chunks.low.y(); y <= chunks.high.y(); ++y) {
    for (int x = first; x < end; ++x) {
      if (raster_.row(y)[x] != Ground::kLow) continue;
      for (auto& price : chunks_.row(y)[x / kChunkCells].price) {
        Ticks& p = price[static_cast<std::size_t>(x % kChunkCells)];
        p = sum(p, prices_.low());
      }
    }
  }
}

void SurveyedFloor::remember(const CellBox& chunks) {
  before_.clear();
  for (int y = chunks.low.y(); y <= chunks.high.y(); ++y)
    before_.insert(before_.end(), chunks_.row(y) + chunks.low.x(), chunks_.row(y) + chunks.high.x() + 1);
}

void SurveyedFloor::list_changes(const CellBox& chunks) {
  auto before = before_.begin();
  for (int y = chunks.low.y(); y <= chunks.high.y(); ++y) {
    for (int i = chunks.low.x(); i <= chunks.high.x(); ++i, ++before)
      if (const auto change = change_of(y, i, *before, chunks_.row(y)[i])) changes_.chunks.push_back(*change);
  }
}

std::size_t SurveyedFloor::bytes() const {
  return chunks_.bytes() + map_.size() * sizeof(Floor) + ground_.size() * sizeof(Ground) + blocked_.bytes() +
         tight_.bytes() + low_.bytes() + changed_.size() * sizeof(Span);
}

}  // namespace headway::nav
