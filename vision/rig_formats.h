// One reader and, where other tools want to read what we calibrated, one writer for each format that stereo
// calibrations come in. rig_files.h finds out which a file has.
#pragma once

#include <filesystem>

#include "config/yaml_reader.h"
#include "vision/rig.h"

namespace headway::vision {

/// What other tools' files do not say: the depths [m] a rig is used for, and in OpenCV's the size of the
/// images.
struct RigDefaults {
  double nearest = 0.8, farthest = 8.0;  ///< [m]
  int width = 0, height = 0;             ///< [px]; zero: the file must say it
};

// All throw InputError `file:line: key: what, expected what`. Keys that they do not need are passed over,
// except in our own format.

/// Our own (config/hrp2/rigs/bottom.yaml shows it; `lens`: radial_tangential, rational or equidistant). Keys
/// are marked as read, the caller calls `finish`.
StereoRig rig_from(const config::Section& section);

/// ROS camera_info, as camera_calibration writes it for each camera. The cameras' poses follow from
/// rectification_matrix and from projection_matrix of the right camera, whose [0, 3] is -focal * baseline.
StereoRig rig_from_camera_infos(const config::Section& left, const config::Section& right,
                                const RigDefaults& defaults);

/// Kalibr's camchain: cam0 is left, cam1 right, cam1.T_cn_cnm1 takes points of cam0 to cam1. camera_model
/// pinhole with radtan, equidistant or none.
StereoRig rig_from_kalibr(const config::Section& chain, const RigDefaults& defaults);

/// OpenCV: M1 D1 M2 D2 R T (also K1, cameraMatrix1, distCoeffs1 ...), as its sample stereo_calib writes them
/// in intrinsics.yml and extrinsics.yml; for one file pass it twice. 4 or 5 coefficients are
/// radial-tangential, 8 or more rational, and 4 fisheye where `fisheye_model: 1` says so.
StereoRig rig_from_opencv(const config::Section& intrinsics, const config::Section& extrinsics,
                          const RigDefaults& defaults);

/// EuRoC's sensor.yaml of both cameras: T_BS is body from sensor.
StereoRig rig_from_euroc(const config::Section& left, const config::Section& right,
                         const RigDefaults& defaults);

}  // namespace headway::vision
