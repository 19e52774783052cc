// The lumen surface, with radius, plaque and healthy radius at its points.
#pragma once
#include "vci/linalg/types.hpp"

namespace vci {

struct Lumen {
  Vectors points; ///< mm
  Triangles triangles;
  std::vector<int> region;              ///< region of each triangle: 0 for the wall, other numbers for caps
  std::vector<double> radius;           ///< local lumen radius at each point, mm
  std::vector<double> plaque;           ///< plaque thickness, mm
  std::vector<int> plaque_type;         ///< 0 none, 1 fibrous, 2 lipid, 3 calcified
  std::vector<double> reference_radius; ///< radius without disease, mm; empty if it is not given
  std::vector<int> branch;              ///< branch of each triangle; empty: all belong to one branch
};

} // namespace vci
