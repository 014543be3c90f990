// What is done to disparities after matching: a median against single wrong pixels, and patches too small to
// be surfaces dropped. Disparities are fixed-point numbers of at least 0; negative ones mean "no match".
#pragma once

#include <cstdint>
#include <vector>

namespace headway::vision {

/// The median of each pixel and its eight neighbours; above the first row and below the last those rows go
/// on, the first and last columns are copied. "No match" counts as a low value. Row-major images of width x
/// height; `out` must have the size of `in` and be another.
void median_3x3(int width, int height, const std::int16_t* in, std::int16_t* out);

/// Patches of pixels whose neighbours (4) differ by at most `step`: those of up to `largest` pixels become
/// `none`.
class SpeckleFilter {
 public:
  /// Memory is kept from image to image; it grows only when an image is larger than all before.
  void drop(int width, int height, int largest, int step, std::int16_t none, std::int16_t* disparity);

 private:
  struct Run {  // of pixels of one row that belong together
    int begin, end;
    int patch;  // index of another run of its patch, nearer to the root; of itself at the root
    int size;   // of the patch, at the root
  };
  int root(int run);
  void join(int one, int other);
  int add_runs(const std::int16_t* row, int width, int step);
  void join_rows(int above, int middle, int end, const std::int16_t* row, int width, int step);

  std::vector<Run> runs_;
  std::vector<int> first_run_;  // of each row
};

}  // namespace headway::vision
