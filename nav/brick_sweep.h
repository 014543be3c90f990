// The plain values that a view's sweep over the map works with (nav/brick_update).
//
// Depths are in steps, as samples have them; "u" and "v" are X and Y of the camera's frame times the focal
// length in the same steps, so that u/z is in samples.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "hal/time.h"
#include "nav/brick.h"
#include "nav/range_samples.h"
#include "nav/voxel_marks.h"

namespace headway::nav {

constexpr int kBoxes = 8;  // classified together: bricks of a row, or the cubes of a brick
constexpr int kCubeVoxels = 64, kRows = 16;
constexpr float kMostSteps = 32767;

// Added to a float of less than 2^22 it leaves the nearest whole number in the lower bits.
constexpr float kToWhole = 12582912;  // 1.5 * 2^23

/// Coordinates of the camera's frame in steps of depth, X and Y times the focal length (so that X/Z is in
/// samples), as linear forms of a voxel's whole coordinates x, y, z and 1.
struct CameraForms {
  float u[4], v[4], z[4];
};

/// Per side of the image (the planes through the camera and its left, right, upper and lower border).
struct Sides {
  float left, right, top, bottom;
};

/// What the sweep needs to know; nothing here changes from brick to brick.
struct Sweep {
  CameraForms forms;
  Eigen::Vector3i first, last;  // the box of bricks that may lie in the view, inclusive
  float planes[6][4];           // a brick's centre voxel (x, y, z, 1) may be in view where all are >= 0
  float cx, cy, end_u, end_v;
  Sides slopes;             // u/z or v/z of the image's border
  float near, far;          // steps
  float half_voxel;         // half an edge of a voxel, as forms.u has it
  int width, height;        // samples
  const SampleWord* words;  // with the ring
  std::int32_t stride;
  const DepthBounds* bounds;
  const SampleClasses* classes;
  VoxelMarks* marks;
  LogOdds least_hit, least_before_hit;
  bool wide;  // some hits are less than least_hit
  Time stamp;
};

/// The voxels of the foot, and those where an obstacle's hit tells of the foot, of a cube of 4x4x4.
struct FootMasks {
  std::uint64_t foot = 0, obstacle = 0;
};

/// What happened to one brick.
struct BrickChange {
  int unseen = 0, occupied = 0;  // differences
  bool changed = false;

  void add(const BrickChange& other) {
    unseen += other.unseen;
    occupied += other.occupied;
    changed |= other.changed;
  }
};

/// What one cube's voxels are told, as bits in their order.
struct CubeBits {
  std::uint64_t hits = 0, misses = 0;
};

struct Place {
  float u, v, z;
};
/// Boxes that are classified together, from a place that they have in common.
struct Boxes {
  alignas(64) float u[kBoxes], v[kBoxes], z[kBoxes];  // their middles
  Place half;                                         // of their extent
  Sides reach;                                        // of their voxels from the middle towards each side

  Place middle(const Place& from, int box) const {
    return {from.u + u[box], from.v + v[box], from.z + z[box]};
  }
};
/// Bit per box.
struct BoxClasses {
  unsigned alive = 0;   // may hold voxels that learn something
  unsigned clear = 0;   // lie in front of all that the image shows where they project to
  unsigned inside = 0;  // all of their voxels lie wholly in the image
  unsigned empty() const { return alive & clear & inside; }
};

}  // namespace headway::nav
