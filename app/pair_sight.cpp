#include "app/pair_sight.h"

namespace headway::app {

bool PairSight::in_view(const Eigen::Vector3d& p) const {
  if (!(p.z() >= nearest && p.z() <= farthest)) return false;
  const double u = camera.cx + camera.focal * p.x() / p.z(), v = camera.cy + camera.focal * p.y() / p.z(),
               u_right = u - camera.focal * baseline / p.z();
  return u_right >= 0 && v >= 0 && u <= camera.width - 1 && v <= camera.height - 1;
}

bool PairSight::in_sight(const sim::Scene& scene, const Eigen::Isometry3d& map_from_view,
                         const Eigen::Vector3d& point) const {
  return scene.sees(map_from_view.translation(), point) &&
         scene.sees(map_from_view * Eigen::Vector3d(baseline, 0, 0), point);
}

}  // namespace headway::app
