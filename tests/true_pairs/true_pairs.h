// Rectified stereo pairs whose disparities are known, to hold matchers against.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "hal/frame.h"
#include "vision/disparity.h"

namespace headway {

struct TruePair {
  std::string name;
  int disparities = 64;  ///< to search, from 0; a multiple of 16
  hal::GrayImage left, right;
  /// The right image half a row lower, as a camera that was knocked shows it: resampled where the pair is
  /// real, taken anew where it is rendered.
  hal::GrayImage right_askew;
  /// NaN where it is unknown, and in the first `disparities` columns: OpenCV's matchers leave them out.
  vision::DisparityImage truth;
};

/// The pairs that the matcher's penalties and the curves of sigma and weight were chosen with: motorcycle
/// (640 x 480), aloe (half size), tsukuba. Those that are at hand.
std::vector<TruePair> real_pairs();

/// Pairs that nothing was chosen with. Rooms of the simulator (lab, maze and two made-up ones), photographs
/// on boards and on a floor (photos: Debian's opencv-doc), and a rendered living room with photographic
/// textures whose right view follows from its depths (living_room: HEADWAY_DATA). Those that are at hand;
/// rooms always.
std::vector<TruePair> held_out_pairs();

// The parts of the above.
std::vector<TruePair> room_pairs();
std::vector<TruePair> photo_pairs();
std::vector<TruePair> synthesised_pairs();

/// Half a row lower, interpolated between rows.
hal::GrayImage half_a_row_lower(const hal::GrayImage& image);

/// Sets the disparities that hold all of the truth, and takes out the truth that OpenCV's matchers leave out.
inline void search_all(TruePair& pair) {
  float most = 0;
  for (const float d : pair.truth.values) most = std::max(most, d);  // NaN is never above
  pair.disparities = (static_cast<int>(most) + 2 + 15) / 16 * 16;
}
inline void leave_out_first_columns(TruePair& pair) {
  for (int v = 0; v < pair.truth.height; ++v)
    for (int u = 0; u < std::min(pair.disparities, pair.truth.width); ++u)
      pair.truth.values[pair.truth.index(u, v)] = vision::DisparityImage::kNone;
}

}  // namespace headway
