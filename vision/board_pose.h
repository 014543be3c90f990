// Where a board stands before a camera, from one view of it; and how far the view is from what that says.
#pragma once

#include <Eigen/Geometry>

#include "vision/board.h"
#include "vision/rig.h"

namespace headway::vision {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The pose after a small motion within its own frame: a rotation vector [rad], then a translation [m].
Eigen::Isometry3d moved(const Eigen::Isometry3d& pose, const Vector6d& motion);

/// Seen corners less projected ones, x and y of each in turn [px]. Corners behind the camera give NaN.
Eigen::VectorXd reprojection_residuals(const CameraIntrinsics& camera,
                                       const Eigen::Isometry3d& camera_from_board, const Board& board,
                                       const BoardView& view);

/// The pose that projects the corners nearest to where they are seen. Needs four corners not in one line;
/// throws InputError when there is no such pose.
Eigen::Isometry3d camera_from_board(const CameraIntrinsics& camera, const Board& board,
                                    const BoardView& view);

}  // namespace headway::vision
