#include "sim_hal/texture.h"

#include <algorithm>
#include <cmath>

#include "sim_hal/noise.h"

namespace headway::sim {

using Eigen::Vector3f;

namespace {

// Standard deviation of the lattice noise below, for corner values uniform in [-1, 1] (measured).
constexpr float kNoiseDeviation = 0.37F;

// floor() without the library call that baseline x86-64 makes of it.
inline int floor_of(float v) {
  const int i = static_cast<int>(v);
  return i - static_cast<int>(static_cast<float>(i) > v);
}

inline float smooth(float t) { return t * t * (3.0F - 2.0F * t); }

inline float corner(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x7feb352dU;
  h ^= h >> 15;
  h *= 0x846ca68bU;
  return static_cast<float>(static_cast<std::int32_t>(h)) * (1.0F / 2147483648.0F);
}

// Value noise: a random value at each corner of a unit lattice, smoothly interpolated. In [-1, 1].
float lattice_noise(float x, float y, float z, std::uint32_t key) {
  constexpr std::uint32_t kX = 0x9e3779b1U, kY = 0x85ebca77U, kZ = 0xc2b2ae3dU;
  const int ix = floor_of(x), iy = floor_of(y), iz = floor_of(z);
  const float u = smooth(x - static_cast<float>(ix)), v = smooth(y - static_cast<float>(iy)),
              w = smooth(z - static_cast<float>(iz));
  const std::uint32_t h = static_cast<std::uint32_t>(ix) * kX + static_cast<std::uint32_t>(iy) * kY +
                          static_cast<std::uint32_t>(iz) * kZ + key;
  const auto edge = [u](std::uint32_t k) {
    const float a = corner(k);
    return a + u * (corner(k + kX) - a);
  };
  const auto face = [&](std::uint32_t k) {
    const float a = edge(k);
    return a + v * (edge(k + kY) - a);
  };
  const float a = face(h);
  return a + w * (face(h + kZ) - a);
}

}  // namespace

TextureSampler::TextureSampler(const Texture& texture, std::uint64_t seed)
    : kind_(texture.kind),
      brightness_(static_cast<float>(texture.brightness)),
      contrast_(static_cast<float>(texture.contrast)),
      octaves_(std::clamp(texture.octaves, 1, kMostOctaves)) {
  amplitude_ = contrast_ / 2 / (kNoiseDeviation * std::sqrt(static_cast<float>(octaves_)));
  for (int i = 0; i < octaves_; ++i) {
    const auto n = static_cast<std::uint64_t>(i);
    Octave& o = octave_[static_cast<std::size_t>(i)];
    o.grain = static_cast<float>(std::ldexp(texture.grain, i));
    o.per_grain = 1 / o.grain;
    o.key = static_cast<std::uint32_t>(mixed(noise_key(seed, n)));
    for (int axis = 0; axis < 3; ++axis)
      o.offset[axis] =
          static_cast<float>(64 * uniform(noise_key(seed, n, 7), static_cast<std::uint64_t>(axis)));
  }
}

float TextureSampler::reflectance(const Vector3f& own_point, float footprint) const {
  switch (kind_) {
    case Texture::Kind::kNoise:
      return noise(own_point, footprint);
    case Texture::Kind::kChecker:
      return checker(own_point, footprint);
    case Texture::Kind::kPlain:
      break;
  }
  return brightness_;
}

float TextureSampler::noise(const Vector3f& p, float footprint) const {
  float sum = 0;
  // From coarse to fine: a grain of one pixel is gone, one of two pixels is there in full.
  for (int i = octaves_ - 1; i >= 0; --i) {
    const Octave& o = octave_[static_cast<std::size_t>(i)];
    const float weight = o.grain / footprint - 1.0F;
    if (weight <= 0) break;
    const float value = lattice_noise(p.x() * o.per_grain + o.offset.x(), p.y() * o.per_grain + o.offset.y(),
                                      p.z() * o.per_grain + o.offset.z(), o.key);
    sum += std::min(weight, 1.0F) * value;
  }
  return std::clamp(brightness_ * (1.0F + amplitude_ * sum), 0.0F, 1.0F);
}

float TextureSampler::checker(const Vector3f& p, float footprint) const {
  const Octave& o = octave_[0];
  // A little towards the object's centre: its faces may lie exactly on the lattice.
  const float scale = o.per_grain * (1.0F - 0x1p-12F);
  const int fields = floor_of(p.x() * scale) + floor_of(p.y() * scale) + floor_of(p.z() * scale);
  const float weight = std::clamp(o.grain / footprint - 1.0F, 0.0F, 1.0F);
  return brightness_ * (1.0F + ((fields & 1) != 0 ? -0.5F : 0.5F) * contrast_ * weight);
}

}  // namespace headway::sim
