// What share of the light each point of a surface gives back, as a function of the point in the object's own
// frame: it moves with the object, looks the same from both eyes, and has no detail finer than a pixel.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "sim_hal/world.h"

namespace headway::sim {

class TextureSampler {
 public:
  /// `seed` makes two objects with the same texture differ.
  TextureSampler(const Texture& texture, std::uint64_t seed);

  /// In [0, 1]. `footprint` [m] is how much of the surface a pixel covers: detail below about two pixels
  /// fades away.
  float reflectance(const Eigen::Vector3f& own_point, float footprint) const;

 private:
  float noise(const Eigen::Vector3f& p, float footprint) const;
  float checker(const Eigen::Vector3f& p, float footprint) const;

  static constexpr int kMostOctaves = 12;
  struct Octave {
    float grain = 1, per_grain = 1;
    Eigen::Vector3f offset{0, 0, 0};  ///< of the lattice [grains]
    std::uint32_t key = 0;
  };

  Texture::Kind kind_;
  float brightness_, contrast_;
  float amplitude_ = 0;  ///< of each octave, relative to the brightness
  int octaves_;
  std::array<Octave, kMostOctaves> octave_;
};

}  // namespace headway::sim
