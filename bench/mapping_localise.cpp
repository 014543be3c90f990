// What it takes to find the robot's place in the map again, for one view: CPU time of making patches of it,
// of aligning them, and of remembering the surfaces; and how far off the place is that was found.
#include <algorithm>
#include <cmath>
#include <vector>

#include "bench/cpu_time.h"
#include "bench/figures.h"
#include "bench/mapping_room.h"
#include "nav/integrate.h"
#include "nav/localise.h"

namespace headway {
namespace {

using Eigen::Vector3d;

/// A room that has been looked at from one place, twice in each direction.
class KnownPlace {
 public:
  KnownPlace() : map_(box()), surfaces_(map_.resolution()) {
    for (const std::uint64_t seed : {1, 2}) {
      for (const bench::PosedView& look : views(seed)) {
        integrator_.integrate(map_, look.view, look.map_from_camera, Time{});
        nav::view_patches(look.view, {}, patches_);
        learn(look);
      }
    }
  }

  static std::vector<bench::PosedView> views(std::uint64_t seed) {
    return bench::look_around(bench::Room(), {.width = 340, .height = 480, .field = 33},
                              {.blur = 1, .seed = seed});
  }
  void make_patches(const bench::PosedView& look) { nav::view_patches(look.view, {}, patches_); }
  void learn(const bench::PosedView& look) { surfaces_.add(patches_, look.map_from_camera, map_); }

  /// From a pose that is `change` off.
  nav::Alignment align(const bench::PosedView& look, const Vector3d& change) {
    Eigen::Isometry3d believed = look.map_from_camera;
    believed.linear() =
        Eigen::AngleAxisd(-change.z(), Vector3d::UnitZ()).toRotationMatrix() * believed.linear();
    believed.translation() -= Vector3d(change.x(), change.y(), 0);
    const Vector3d sigma(0.02, 0.02, 0.01);
    return localiser_.align(map_, surfaces_, patches_, believed, believed.translation().head<2>(),
                            sigma.cwiseAbs2().asDiagonal());
  }

 private:
  static nav::VoxelMapConfig box() {
    nav::VoxelMapConfig config;
    config.lowest = {-4, -4, -0.4};
    config.highest = {4, 4, 3.2};
    return config;
  }

  nav::VoxelMap map_;
  nav::Integrator integrator_;
  nav::SurfacePoints surfaces_;
  nav::Localiser localiser_;
  std::vector<nav::Patch> patches_;
};

void localisation_of_views(benchmark::State& state) {
  KnownPlace place;
  const std::vector<bench::PosedView> looks = KnownPlace::views(3);
  const Vector3d change(0.015, -0.01, 0.005);
  double patches = 0, align = 0, learn = 0, error = 0;
  int aligned = 0;
  for (auto _ : state) {
    for (const bench::PosedView& look : looks) {
      bench::LeastTime times[3];
      nav::Alignment found;
      for (int round = 0; round < 5; ++round) {
        times[0].take([&] { place.make_patches(look); });
        times[1].take([&] { found = place.align(look, change); });
        times[2].take([&] { place.learn(look); });
      }
      patches += times[0].seconds();
      align += times[1].seconds();
      learn += times[2].seconds();
      if (!found) continue;
      ++aligned;
      // Where the view tells nothing, nothing is found: errors count by what it says it knows.
      const Vector3d off = found.change - change;
      error = std::max(error, std::sqrt(off.dot(found.information * off)));
    }
  }
  const double views = static_cast<double>(looks.size());
  bench::figure("localise_patches_ms", 1e3 * patches / views);
  bench::figure("localise_align_ms", 1e3 * align / views);
  bench::figure("localise_learn_ms", 1e3 * learn / views);
  bench::figure("localise_ms", 1e3 * (patches + align + learn) / views);
  bench::figure("localise_views_aligned_of_9", aligned);
  bench::figure("localise_error_sigmas_max", error);
}
BENCHMARK(localisation_of_views)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace headway
