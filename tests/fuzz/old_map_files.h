// Headway's map files as older versions wrote them.
#pragma once

#include <cstddef>
#include <sstream>
#include <string>

#include "nav/checksum.h"
#include "nav/cold_map_file.h"
#include "nav/little_endian.h"

namespace headway::fuzz {

/// The contents of a map file, with their checksum.
inline std::string with_sum(std::string bytes) {
  nav::Checksum sum;
  sum.add(bytes);
  return bytes.append(nav::LittleEndian<4>(sum.value()).text());
}

/// Of today's, the checksum left out, with another version in the first line.
inline std::string body_of(const nav::ColdMap& map, const nav::SurfacePoints& surfaces, char version) {
  std::ostringstream file;
  nav::write_map_file(map, surfaces, file);
  std::string bytes = file.str();
  bytes.resize(bytes.size() - 4);
  bytes[bytes.find('\n') - 1] = version;
  return bytes;
}

/// Without surfaces.
inline std::string of_version_1(const nav::ColdMap& map) {
  std::string bytes = body_of(map, nav::SurfacePoints(map.resolution()), '1');
  bytes.resize(bytes.size() - 8);  // their number
  return with_sum(bytes);
}

/// With surfaces, without the rays that met them.
inline std::string of_version_2(const nav::ColdMap& map, const nav::SurfacePoints& surfaces) {
  constexpr std::size_t kVoxel = 68, kOfRays = 12;  // bytes
  std::string bytes = body_of(map, surfaces, '2');
  for (std::size_t i = 0, end = bytes.size(); i < surfaces.voxels(); ++i, end -= kVoxel)
    bytes.erase(end - kOfRays, kOfRays);
  return with_sum(bytes);
}

}  // namespace headway::fuzz
