#include "vision/piece_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <opencv2/imgproc.hpp>

#include "vision/cv_image.h"

namespace headway::vision {

namespace {

constexpr int kCellsAcross = 16, kCellsDown = 12;
constexpr double kCorner = 4e-5;        // least cv::cornerMinEigenVal of a corner worth looking for
constexpr double kAlike = 0.8;          // correlation of a piece with its partner
constexpr double kUnlikeOthers = 0.05;  // and so much better than the second best

// A square piece around (u, v), its mean taken out, so that a sum of products is a correlation but for the
// lengths. Images of 16 bits: what the processor multiplies and adds eight at a time.
template <int kSide>
struct Piece {
  std::int16_t grey[kSide][kSide];
  int rest = 0;  // what rounding leaves of the mean
  double length = 0;

  Piece(const cv::Mat& image, int u, int v) {
    int sum = 0, squares = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) sum += row(image, u, v, y)[x];
    const int mean = (sum + kSide * kSide / 2) / (kSide * kSide);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const int g = row(image, u, v, y)[x] - mean;
        grey[y][x] = static_cast<std::int16_t>(g);
        squares += g * g, rest += g;
      }
    length = std::sqrt(squares - rest * (static_cast<double>(rest) / (kSide * kSide)));
  }

  static const std::int16_t* row(const cv::Mat& image, int u, int v, int y) {
    return image.ptr<std::int16_t>(v + y - kSide / 2) + u - kSide / 2;
  }

  // Normalised correlation with the piece of `image` around (u, v).
  double likeness(const cv::Mat& image, int u, int v) const {
    int products = 0, sum = 0, squares = 0;
    for (int y = 0; y < kSide; ++y) {
      const std::int16_t* there = row(image, u, v, y);
      for (int x = 0; x < kSide; ++x) {
        products += there[x] * grey[y][x];
        squares += there[x] * there[x];
        sum += there[x];
      }
    }
    const double mean = sum / static_cast<double>(kSide * kSide), spread = squares - sum * mean;
    return spread > 0 && length > 0 ? (products - rest * mean) / (length * std::sqrt(spread)) : 0;
  }
};

constexpr int kCoarse = 8, kFine = 16;  // sides of the pieces [px]

// Whether a square of this side around (u, v) lies in the image, and one row above and below it too.
bool fits(const cv::Mat& image, int u, int v, int side) {
  const int half = side / 2;
  return u >= half && v > half && u + half <= image.cols && v + half < image.rows;
}

cv::Mat reduced(const cv::Mat& image, int factor) {
  cv::Mat out;
  cv::resize(image, out, {image.cols / factor, image.rows / factor}, 0, 0, cv::INTER_AREA);
  return out;
}

cv::Mat widened(const cv::Mat& image) {
  cv::Mat out;
  image.convertTo(out, CV_16S);
  return out;
}

// The strongest corner of each cell that has one.
std::vector<cv::Point> corners(const cv::Mat& image) {
  cv::Mat strength;
  cv::cornerMinEigenVal(image, strength, 5, 3);
  std::vector<cv::Point> found;
  for (int j = 0; j < kCellsDown; ++j)
    for (int i = 0; i < kCellsAcross; ++i) {
      const int left = image.cols * i / kCellsAcross, right = image.cols * (i + 1) / kCellsAcross;
      const int top = image.rows * j / kCellsDown, bottom = image.rows * (j + 1) / kCellsDown;
      if (left >= right || top >= bottom) continue;
      double strongest = 0;
      cv::Point at;
      cv::minMaxLoc(strength({left, top, right - left, bottom - top}), nullptr, &strongest, nullptr, &at);
      if (strongest > kCorner) found.emplace_back(at.x + left, at.y + top);
    }
  return found;
}

struct Place {
  int u = 0, v = 0;
  double likeness = -1;
};

// The best place in a window of the coarse right image; nothing good when another is nearly as good.
Place coarse_place(const cv::Mat& left, const cv::Mat& right, cv::Point at, int lowest, int highest,
                   int rows) {
  const Piece<kCoarse> piece(left, at.x, at.y);
  Place best, second;
  std::vector<Place> tried;
  for (int v = at.y - rows; v <= at.y + rows; ++v)
    for (int u = at.x - highest; u <= at.x - lowest; ++u) {
      if (!fits(right, u, v, kCoarse)) continue;
      const double likeness = piece.likeness(right, u, v);
      tried.push_back({u, v, likeness});
      if (likeness > best.likeness) best = tried.back();
    }
  for (const Place& place : tried)
    if (std::abs(place.u - best.u) + std::abs(place.v - best.v) > 2)
      second.likeness = std::max(second.likeness, place.likeness);
  if (best.likeness < kAlike || best.likeness - second.likeness < kUnlikeOthers) best.likeness = -1;
  return best;
}

// Closes in at full size, to a fraction of a row: the top of the parabola through three correlations.
bool fine_place(const cv::Mat& left, const cv::Mat& right, int reach, PieceMatch& match, int u_right,
                int v_right) {
  if (!fits(left, match.u, match.v, kFine)) return false;
  const Piece<kFine> piece(left, match.u, match.v);
  Place best;
  for (int v = v_right - reach; v <= v_right + reach; ++v)
    for (int u = u_right - reach; u <= u_right + reach; ++u) {
      if (!fits(right, u, v, kFine)) continue;
      const double likeness = piece.likeness(right, u, v);
      if (likeness > best.likeness) best = {u, v, likeness};
    }
  if (best.likeness < kAlike || std::abs(best.v - v_right) == reach || std::abs(best.u - u_right) == reach)
    return false;
  const double above = piece.likeness(right, best.u, best.v - 1),
               below = piece.likeness(right, best.u, best.v + 1);
  const double bend = above - 2 * best.likeness + below;
  if (!(bend < 0)) return false;
  match.disparity = match.u - best.u;
  match.row = best.v - match.v + 0.5 * (above - below) / bend;
  return true;
}

}  // namespace

PieceSearch search_pieces(const hal::GrayImage& left, const hal::GrayImage& right, const RectifiedRig& rig,
                          int rows) {
  const int factor = std::max(1, static_cast<int>(std::lround(std::min(left.width, left.height) / 120.0)));
  cv::Mat small_left = reduced(as_mat(left), factor), small_right = reduced(as_mat(right), factor);
  const auto pieces = corners(small_left);
  constexpr double kCells = kCellsAcross * kCellsDown;

  PieceSearch out;
  out.left_texture = static_cast<double>(pieces.size()) / kCells;
  out.right_texture = static_cast<double>(corners(small_right).size()) / kCells;
  small_left = widened(small_left), small_right = widened(small_right);
  const cv::Mat full_left = widened(as_mat(left)), full_right = widened(as_mat(right));
  // As far behind infinity as the nearest distance is before it.
  const double before = rig.disparity(rig.nearest), infinity = -rig.disparity_offset;
  const int highest = static_cast<int>(std::ceil(before / factor));
  const int lowest = static_cast<int>(std::floor((2 * infinity - before) / factor));
  const int coarse_rows = (rows + factor - 1) / factor;
  for (const cv::Point& at : pieces) {
    if (!fits(small_left, at.x, at.y, kCoarse)) continue;
    ++out.looked_for;
    const Place place = coarse_place(small_left, small_right, at, lowest, highest, coarse_rows);
    if (place.likeness < 0) continue;
    const int middle = factor / 2;
    PieceMatch match{at.x * factor + middle, at.y * factor + middle, 0, 0};
    if (fine_place(full_left, full_right, factor + 1, match, place.u * factor + middle,
                   place.v * factor + middle))
      out.found.push_back(match);
  }
  return out;
}

}  // namespace headway::vision
