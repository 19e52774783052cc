// Ends given as files, each the triangles that close one end.
#pragma once
#include "core/types.hpp"

namespace anatomy {

struct GivenCap {
  std::string path;
  Vec3 centre = Vec3::Zero(); ///< of its area, mm
  double area = 0;            ///< mm2, seen along the normal
  Soup triangles;
};

/// Reads the caps in the unit of the surface. Throws InputError as read_triangles does, and for a cap without area.
std::vector<GivenCap> read_caps(const std::vector<std::string>& paths, const std::string& units);

} // namespace anatomy
