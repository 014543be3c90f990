// Semi-global matching (Hirschmueller, PAMI 2008): for each pixel and disparity the cost of the cheapest way
// there along straight paths over the image, where a change of disparity costs extra. The sum over the paths
// names the winner.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/two_processors.h"
#include "vision/census.h"
#include "vision/sgm_rows.h"

namespace headway::vision {

/// L(p, d) = C(p, d) + min(L(q, d), L(q, d-1) + p1, L(q, d+1) + p1, min L(q) + p2) - min L(q),  q before p on
/// the path.
struct SgmPenalties {
  int p1 = 16;  ///< for a change of disparity by one
  /// For more: p2 * p2_edge / (p2_edge + g), at least p2_least, where g is the step of grey values between p
  /// and q: depth jumps at edges.
  int p2 = 90, p2_least = 40, p2_edge = 16;
  int paths = 4;  ///< 4: from left, right, above, below; 3: not from below, in 60 % of the time
  bool operator==(const SgmPenalties&) const = default;
};

/// Which pixels are matched with which.
struct SgmSearch {
  int width = 0, height = 0;
  int lowest = 0, count = 0;  ///< disparities lowest, lowest + 1, ..., lowest + count - 1; at most 256
  int first_column = 0, end_column = 0;  ///< others are left out
  bool operator==(const SgmSearch&) const = default;
};

/// Row-major, of the left image's size.
struct SgmResult {
  static constexpr std::int16_t kNone = -16;
  static constexpr std::uint8_t kOutside = 255;
  std::vector<std::int16_t> disparity;  ///< 1/16 px above `lowest`; kNone in columns that were left out
  std::vector<std::uint8_t> least,
      second;  ///< sum of the winner, and of the best not beside it; 255 is "or more"
  /// How many pixels the winner of the partner in the right image is off; kOutside where that lies outside,
  /// and where the left pixel's comparisons and slope are all nil. That is so where the image is flat, and
  /// the winner only what the paths brought along; and on the few brightest pixels of a spot that is nowhere
  /// brighter above them than opposite below, which are lost.
  std::vector<std::uint8_t> disagreement;
};

/// Matches pairs of one size after another; with four paths on two processors. Memory is taken when the
/// search changes, never between.
class Sgm {
 public:
  static constexpr int kMostDisparities = 256, kLargestP2 = 90;

  void match(const SgmSearch& search, const SgmPenalties& penalties, const hal::GrayImage& left,
             const hal::GrayImage& right, hal::TwoProcessors& processors, SgmResult& result);

 private:
  /// The rows of one half of the image, counted from its outer edge to the middle, and what is needed to
  /// sweep over them.
  struct Half {
    int first = 0, step = 1;  ///< the outermost row of the image, and which way the next one lies
    int rows = 0, blocks = 0;
    SgmFacts facts;
    std::uint8_t *saved = nullptr, *costs = nullptr, *sums = nullptr;
    SgmRowOutput row{};
    int row_at(int i) const { return first + step * i; }
  };
  void prepare(const SgmSearch& search, const SgmPenalties& penalties);
  void take_memory();
  SgmRowInput input(const hal::GrayImage& left, int y, int before) const;
  void finish_row(const SgmRowOutput& row, int y, SgmResult& result) const;
  std::uint8_t* saved(const Half& half, int block) const;
  void sweep_down(const hal::GrayImage& left, SgmResult& result);
  void approach_middle(const hal::GrayImage& left, const Half& half) const;
  void leave_middle(const hal::GrayImage& left, const Half& half, std::uint8_t* across,
                    SgmResult& result) const;

  SgmSearch search_;
  SgmPenalties penalties_;
  SgmFacts facts_;
  SgmKernels kernels_{};
  Census left_, right_;
  int block_rows_ = 0;
  std::vector<std::uint8_t> memory_;
  std::array<Half, 2> halves_;  ///< from above, from below; with three paths the first is the whole image
};

}  // namespace headway::vision
