// From the scene to images: what one eye sees.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "hal/frame.h"
#include "sim_hal/imager.h"
#include "sim_hal/lens.h"
#include "sim_hal/scene.h"

namespace headway::sim {

/// An image of the scene through a lens. `rays` is ray_table(lens). `noise` names the frame and eye.
void render(const Scene& scene, const Lens& lens, const std::vector<Eigen::Vector2f>& rays,
            const Imager& imager, const Eigen::Isometry3d& map_from_camera, std::uint64_t noise,
            hal::GrayImage& into);

/// Truth for evaluation: Z [m] along each ray of a ray_table, in its order; infinity where nothing is.
std::vector<float> true_depth(const Scene& scene, const std::vector<Eigen::Vector2f>& rays,
                              const Eigen::Isometry3d& map_from_camera);

}  // namespace headway::sim
