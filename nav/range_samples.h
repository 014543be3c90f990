// A range image made ready for the map: fewer samples, without outliers, each with the depths that tell a
// voxel in front of its surface from one on it and one behind; and the bounds of these over whole rectangles.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "nav/integrate.h"
#include "nav/inverse_depth.h"
#include "nav/ring_image.h"
#include "nav/voxel_marks.h"
#include "vision/range_view.h"

namespace headway::nav {

/// One sample in 32 bits, from the highest: where nothing is empty any more (14 bits), where the surface ends
/// (14 bits), both in steps of depth; and how wide sigma is beside a voxel (4 bits, index of SampleClasses).
/// Zero where nothing is known.
using SampleWord = std::uint32_t;
namespace sample_word {
inline constexpr int kFrontShift = 18, kBackShift = 4;
inline constexpr SampleWord kDepthMask = 0x3fff, kClassMask = 15;
}  // namespace sample_word

/// Where between front and back the surface lies, and how sure a hit there is, by the width of sigma. Shares
/// are in 256ths of the way from front to back (or, of `own_end`, from back to front).
struct SampleClasses {
  static constexpr int kCount = 16;
  using Table = std::array<std::uint8_t, kCount>;
  alignas(16) Table hit_begin;     ///< from here on it is a hit
  alignas(16) Table own_begin;     ///< the surface's own voxel as it would be without sigma: from here ...
  alignas(16) Table own_end;       ///< ... to there
  alignas(16) Table short_of_hit;  ///< log-odds of a hit below those of a full one

  /// Nothing is emptied nearer than `free_sigmas` to a surface; hits reach `hit_sigmas` to both sides.
  SampleClasses(double free_sigmas, double hit_sigmas);
};

/// The voxels of a map as the camera sees them, for marking: voxel = turn * ray * Z + origin.
struct MarkFrame {
  Eigen::Matrix3f turn;    ///< [voxels / m]
  Eigen::Vector3f origin;  ///< [voxels]
  Eigen::Vector3i bricks;  ///< of the map
};

/// Least fronts and greatest backs of tiles of 2, 4, 8 ... samples. Tiles overlap by half, so that one of
/// them covers any rectangle up to half its size.
class DepthBounds {
 public:
  static constexpr int kLevels = 8;
  /// Front in the lower, back in the upper half.
  using Word = std::uint32_t;

  void build(const RingImage<SampleWord>& samples);

  /// Tile (x, y) of level l (1 .. kLevels) covers samples from (x, y) << l on, 2 << l of them each way:
  /// words()[start()[l] + y * width()[l] + x].
  const Word* words() const { return overlapping_.data(); }
  const std::int32_t* start() const { return start_.data(); }
  const std::int32_t* width() const { return width_.data(); }

 private:
  std::array<std::int32_t, kLevels + 1> start_{}, width_{}, height_{};
  std::vector<Word> tiles_, overlapping_;
};

/// How finely a view is to be read.
struct Sampling {
  double resolution;  ///< a voxel's edge [m]
  RowsRead rows;      ///< where the view is read at a quarter of its size
};

class RangeSamples {
 public:
  /// Takes a view in, and marks in `marks` the voxels that the edges of its surfaces lie in.
  void take(const vision::RangeView& view, const IntegrationConfig& config, const Sampling& sampling,
            const Eigen::Matrix3d& map_from_camera, const Eigen::Isometry3d& body_from_camera,
            const MarkFrame& frame, VoxelMarks& marks);

  /// Of the reduced image: u = focal() X/Z + cx(); sample centres lie at whole numbers.
  const RingImage<SampleWord>& words() const { return words_; }
  float focal() const { return focal_; }
  float cx() const { return cx_; }
  float cy() const { return cy_; }
  /// The camera's image covers -0.5 <= u < end_u(), -0.5 <= v < end_v().
  float end_u() const { return end_u_; }
  float end_v() const { return end_v_; }
  float near() const { return near_; }  ///< [m]
  /// Nothing is said about voxels farther than this [m]: the view's far, or behind all surfaces.
  float farthest() const { return std::min(far_, static_cast<float>(farthest_) / steps_per_metre_); }
  float steps_per_metre() const { return steps_per_metre_; }  ///< of depth
  std::size_t widest() const { return widest_; }              ///< greatest class of a sample
  double hit_sigmas() const { return hit_sigmas_; }           ///< that hits reach to both sides
  const DepthBounds& bounds() const { return bounds_; }

  std::size_t used() const { return used_; }
  std::size_t rejected() const { return rejected_; }

 private:
  void set_camera(const vision::PinholeCamera& camera, int reduction);
  void forget_own_body(const std::vector<BodyBox>& boxes, const Eigen::Isometry3d& body_from_camera);

  float focal_ = 0, cx_ = 0, cy_ = 0, end_u_ = 0, end_v_ = 0, near_ = 0, far_ = 0, steps_per_metre_ = 1;
  double hit_sigmas_ = 0;
  std::uint32_t farthest_ = 0, widest_ = 0;
  std::size_t used_ = 0, rejected_ = 0;
  DepthReducer reducer_;
  InverseDepth rough_;
  RingImage<float> smooth_, smoother_, mean_sigma_;
  RingImage<SampleWord> words_;
  DepthBounds bounds_;
};

}  // namespace headway::nav
