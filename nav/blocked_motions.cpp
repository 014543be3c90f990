#include "nav/blocked_motions.h"

#include <algorithm>

namespace headway::nav {

namespace {

/// Word w of the row moved so that bit x becomes the row's bit x + by (|by| < 64). `row` has words to both
/// sides.
std::uint64_t word_ahead(const std::uint64_t* word, int by) {
  if (by == 0) return word[0];
  if (by > 0) return (word[0] >> by) | (word[1] << (64 - by));
  return (word[0] << -by) | (word[-1] >> (64 + by));
}

}  // namespace

void CellBits::reset(int width, int height, bool outside) {
  width_ = width;
  height_ = height;
  words_ = (width + 63) / 64 + 2;
  bits_.assign(static_cast<std::size_t>(words_) * static_cast<std::size_t>(height), 0);
  outside_.assign(static_cast<std::size_t>(words_), outside ? ~std::uint64_t{0} : 0);
  if (!outside) return;
  for (int y = 0; y < height; ++y) {
    std::uint64_t* row = row_of(y);
    row[0] = row[words_ - 1] = ~std::uint64_t{0};
    if (width % 64 != 0) row[words_ - 2] = ~std::uint64_t{0} << (width % 64);
  }
}

const std::uint64_t* CellBits::row(int y) const {
  if (y < 0 || y >= height_) return outside_.data();
  return bits_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(words_);
}

void BlockedMotions::reset(int width, int height) {
  width_ = width;
  height_ = height;
  blocked_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), {});
}

MaskDilation::MaskDilation(const Masks& masks) {
  for (int c = 0; c < kConfigurations; ++c) {
    for (const Mask::Run& run : masks.of(c).runs) {
      const Span span{run.first, run.last - run.first + 1};
      sources_[static_cast<std::size_t>(c)].push_back({run.dy, span_number(span)});
      lowest_ = std::min(lowest_, run.dy);
      highest_ = std::max(highest_, run.dy);
      longest_ = std::max(longest_, span.length);
    }
  }
}

int MaskDilation::span_number(const Span& span) {
  const auto known = std::find(spans_.begin(), spans_.end(), span);
  if (known != spans_.end()) return static_cast<int>(known - spans_.begin());
  spans_.push_back(span);
  return static_cast<int>(spans_.size()) - 1;
}

void MaskDilation::make_room(int width) {
  words_ = (width + 63) / 64;
  const auto words = static_cast<std::size_t>(words_);
  runs_.resize(static_cast<std::size_t>(longest_) * (words + 2));
  ring_.resize(static_cast<std::size_t>(highest_ - lowest_ + 1) * spans_.size() * words);
  hit_.resize(kMotions * words);
}

std::uint64_t* MaskDilation::dilated(int y, int span) {
  const int rows = highest_ - lowest_ + 1;
  const auto slot = static_cast<std::size_t>((y + rows) % rows);
  return ring_.data() +
         (slot * spans_.size() + static_cast<std::size_t>(span)) * static_cast<std::size_t>(words_);
}

void MaskDilation::dilate_row(const CellBits& obstacles, int y) {
  const std::uint64_t* row = obstacles.row(y);
  const int stride = words_ + 2;
  const auto run_of = [&](int length) { return runs_.data() + (length - 1) * stride; };
  std::copy(row, row + stride, run_of(1));
  for (int length = 2; length <= longest_; ++length) {
    const std::uint64_t* shorter = run_of(length - 1);
    std::uint64_t* longer = run_of(length);
    longer[stride - 1] = row[stride - 1];  // all of it lies outside
    for (int w = 0; w + 1 < stride; ++w) longer[w] = shorter[w] | word_ahead(row + w, length - 1);
  }
  for (int s = 0; s < static_cast<int>(spans_.size()); ++s) {
    const Span& span = spans_[static_cast<std::size_t>(s)];
    const std::uint64_t* source = run_of(span.length) + 1;
    std::uint64_t* into = dilated(y, s);
    for (int w = 0; w < words_; ++w) into[w] = word_ahead(source + w, span.first);
  }
}

void MaskDilation::block_row(int y, BlockedMotions& into) {
  for (int heading = 0; heading < kHeadings; ++heading) {
    std::fill(hit_.begin(), hit_.end(), 0);
    for (int number = 0; number < kMotions; ++number) {
      std::uint64_t* hit = hit_.data() + number * words_;
      for (const Source& s : sources_[static_cast<std::size_t>(Motion{heading, number}.configuration())]) {
        const std::uint64_t* row = dilated(y + s.dy, s.span);
        for (int w = 0; w < words_; ++w) hit[w] |= row[w];
      }
    }
    scatter(y, heading, into);
  }
}

/// From a row of cells per motion to the motions of each cell.
void MaskDilation::scatter(int y, int heading, BlockedMotions& into) const {
  const std::size_t begin = static_cast<std::size_t>(y) * static_cast<std::size_t>(into.width());
  for (int w = 0; w < words_; ++w) {
    std::array<std::uint64_t, kMotions> hit{};
    std::uint64_t any = 0;
    for (std::size_t k = 0; k < kMotions; ++k) {
      hit[k] = hit_[k * static_cast<std::size_t>(words_) + static_cast<std::size_t>(w)];
      any |= hit[k];
    }
    const int last = std::min(64, into.width() - 64 * w);
    for (int x = 0; any != 0 && x < last; ++x) {
      unsigned motions = 0;
      for (std::size_t k = 0; k < kMotions; ++k) motions |= static_cast<unsigned>(hit[k] >> x & 1) << k;
      into.block(begin + static_cast<std::size_t>(64 * w + x), heading, motions);
    }
  }
}

void MaskDilation::block(const CellBits& obstacles, int first, int last, BlockedMotions& into) {
  make_room(into.width());
  for (int y = first + lowest_; y < first + highest_; ++y) dilate_row(obstacles, y);
  for (int y = first; y <= last; ++y) {
    dilate_row(obstacles, y + highest_);
    block_row(y, into);
  }
}

}  // namespace headway::nav
