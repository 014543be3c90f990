#include "sim_hal/render.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim_hal/noise.h"
#include "sim_hal/texture.h"

namespace headway::sim {

using Eigen::Isometry3d, Eigen::Matrix3f, Eigen::Vector2f, Eigen::Vector3f;

namespace {

constexpr float kSky = 0.6F;  // of rays that leave the world

std::vector<TextureSampler> samplers(const Scene& scene) {
  const World& world = scene.world();
  std::vector<TextureSampler> all;
  const int count = static_cast<int>(scene.solids().size());
  all.reserve(static_cast<std::size_t>(count) + 1);
  for (int surface = kFloorSurface; surface < count; ++surface)
    all.emplace_back(world.textures[static_cast<std::size_t>(scene.texture_of(surface))],
                     noise_key(world.seed, static_cast<std::uint64_t>(surface + 1), 0x7e87));
  return all;
}

// The light that comes back from where rays went.
class Shader {
 public:
  Shader(const Scene& scene, const Lens& lens)
      : samplers_(samplers(scene)),
        light_(scene.world().light.cast<float>()),
        ambient_(static_cast<float>(scene.world().ambient)),
        pixel_angle_(static_cast<float>(1 / std::sqrt(lens.fx * lens.fy))) {}

  // `direction` has z = 1 in the camera's frame, so that the distance is the depth.
  float operator()(const RayHit& hit, const Vector3f& origin, const Vector3f& direction) const {
    if (!hit.met()) return kSky;
    const Vector3f point = origin + hit.distance * direction;
    const Vector3f to_light = light_ - point;
    const float lambert =
        std::max(0.0F, hit.normal.dot(to_light)) / std::sqrt(to_light.squaredNorm() + 1e-12F);
    // A pixel on a slanted surface is long and narrow; its geometric mean keeps the detail across.
    const float slant = std::max(-hit.normal.dot(direction), 0.02F * direction.norm()) / direction.norm();
    const float footprint = hit.distance * pixel_angle_ / std::sqrt(slant);
    const float reflected = samplers_[static_cast<std::size_t>(hit.surface - kFloorSurface)].reflectance(
        hit.own_point, footprint);
    return reflected * (ambient_ + (1 - ambient_) * lambert);
  }

 private:
  std::vector<TextureSampler> samplers_;
  Vector3f light_;
  float ambient_, pixel_angle_;
};

// Casts all rays of a camera, sixteen neighbours at a time: per_ray(index, hit, direction in the map frame).
template <class PerRay>
void cast_all(const Scene& scene, const std::vector<Vector2f>& rays, const Isometry3d& map_from_camera,
              PerRay per_ray) {
  constexpr std::size_t kSize = RayPacket::kSize;
  const Matrix3f rotation = map_from_camera.linear().cast<float>();
  const Vector3f origin = map_from_camera.translation().cast<float>();
  RayPacket packet;
  std::array<RayHit, kSize> hits;
  for (std::size_t first = 0; first < rays.size(); first += kSize) {
    const std::size_t count = std::min(kSize, rays.size() - first);
    packet.count = static_cast<int>(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Vector2f& n = rays[first + i];
      const Vector3f d = rotation.col(0) * n.x() + rotation.col(1) * n.y() + rotation.col(2);
      packet.dx[i] = d.x(), packet.dy[i] = d.y(), packet.dz[i] = d.z();
    }
    scene.cast(origin, packet, hits);
    for (std::size_t i = 0; i < count; ++i)
      per_ray(first + i, hits[i], Vector3f(packet.dx[i], packet.dy[i], packet.dz[i]));
  }
}

// Share of the light that arrives at each pixel: less towards the corners.
float vignette(const Lens& lens, std::size_t index, float loss) {
  const auto width = static_cast<std::size_t>(lens.width);
  const float u = 2 * static_cast<float>(index % width) / static_cast<float>(lens.width) - 1;
  const float v = 2 * static_cast<float>(index / width) / static_cast<float>(lens.height) - 1;
  return 1 - loss * (u * u + v * v) / 2;
}

}  // namespace

void render(const Scene& scene, const Lens& lens, const std::vector<Vector2f>& rays, const Imager& imager,
            const Isometry3d& map_from_camera, std::uint64_t noise, hal::GrayImage& into) {
  into.width = lens.width;
  into.height = lens.height;
  into.pixels.resize(rays.size());
  const Shader shade(scene, lens);
  const Vector3f origin = map_from_camera.translation().cast<float>();
  const float white = 255 * static_cast<float>(imager.exposure), loss = static_cast<float>(imager.vignetting),
              sigma = static_cast<float>(imager.noise_sigma);
  cast_all(scene, rays, map_from_camera, [&](std::size_t i, const RayHit& hit, const Vector3f& direction) {
    const bool lit = std::isfinite(direction.x());  // no light comes along where the lens has no ray
    float grey = lit ? white * vignette(lens, i, loss) * shade(hit, origin, direction) : 0.0F;
    grey += sigma * normal(noise, i);
    into.pixels[i] = static_cast<std::uint8_t>(std::clamp(grey + 0.5F, 0.0F, 255.0F));
  });
}

std::vector<float> true_depth(const Scene& scene, const std::vector<Vector2f>& rays,
                              const Isometry3d& map_from_camera) {
  std::vector<float> depth(rays.size());
  cast_all(scene, rays, map_from_camera,
           [&](std::size_t i, const RayHit& hit, const Vector3f&) { depth[i] = hit.distance; });
  return depth;
}

}  // namespace headway::sim
