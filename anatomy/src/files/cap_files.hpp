// Reads cap files. Each holds the triangles that close one end of the vessel.
#pragma once
#include "core/types.hpp"
#include "files/length_unit.hpp"

namespace anatomy {

/// The cap of one end, as the user gives it.
struct GivenCap {
  std::string path;
  Vec3 centre = Vec3::Zero(); ///< mm, centroid of its area
  double area = 0;            ///< mm2, projected along its mean normal
  Soup triangles;
};

/// Reads the caps; `unit` is the surface's. Throws InputError as read_triangles does, and for a cap without area.
std::vector<GivenCap> read_caps(const std::vector<std::string>& paths, LengthUnit unit);

} // namespace anatomy
