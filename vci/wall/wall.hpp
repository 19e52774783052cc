// The arterial wall: the lumen's triangles near the devices with their layers.
#pragma once
#include "vci/geometry/lumen.hpp"
#include "vci/wall/wall_layer.hpp"

namespace vci {

/// The part of the lumen that may move, as body 0 of a system.
struct Wall {
  std::vector<int> vertex;   ///< system vertex -> lumen vertex
  std::vector<int> triangle; ///< body triangle -> lumen triangle
  const Layer* intima;       ///< for the stretch
  int fixed;                 ///< vertices held at the region's border
};

/// Laws of two layers that represent plaque of a thickness (mm) and modulus (MPa) on a lumen of a radius (mm). They lie
/// at the Gauss points in ln R, since the stretch falls with R. In a ring four times as wide outside as inside, the
/// energy is within 2 % of the integral through the thickness. Plaque at the lumen's own strain would have 1.2 to 6.3
/// times that energy. `law` gives yield and Poisson's ratio.
std::array<HenckyLaw, 2> plaque_layers(const HenckyLaw& law, double modulus, double thickness, double radius);

/// Adds the wall to an empty system. `free` flags lumen vertices that may move; vertices of caps never do. `map_pa` is
/// the mean blood pressure in Pa. Throws InputError if no triangle of the wall may move.
Wall add_wall(System& system, const Lumen& lumen, const std::vector<char>& free, const WallSpec& spec, double map_pa);

/// Lumen positions with the wall's moved vertices put in.
Vectors moved_points(const Lumen& lumen, const Wall& wall, const System& system);

} // namespace vci
