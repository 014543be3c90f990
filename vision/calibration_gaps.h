// Why pairs may say too little of a rig, or something wrong: corners of the images where the board never was,
// and pairs whose two images were not taken at one moment.
#pragma once

#include <string>
#include <vector>

#include "vision/board.h"
#include "vision/camera_intrinsics.h"

namespace headway::vision {

/// The corners of the image ("upper left" and so on) near which nothing of the board was ever seen: not in
/// the outer quarter of both width and height [px]. There a lens is only guessed.
std::vector<std::string> unseen_corners(const std::vector<const BoardView*>& views, int width, int height);

/// Which pairs do not fit the place of the right camera that most agree on. Each of them gives one by itself,
/// from where the board stands before either camera; the place that suits the median pair best is taken for
/// true. A pair is torn when its corners are off the right image by more than 3 % of its width, and by ten
/// times what the median pair is. Every pair must show enough (`shows_enough`).
std::vector<bool> torn_pairs(const Board& board, const CameraIntrinsics& left, const CameraIntrinsics& right,
                             const std::vector<SharedCorners>& pairs);

}  // namespace headway::vision
