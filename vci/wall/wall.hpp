// The arterial wall: the lumen's triangles near the devices with their layers.
#pragma once
#include "vci/geometry/lumen.hpp"
#include "vci/wall/wall_layer.hpp"

namespace vci {

/// The part of the lumen that may move, as body 0 of a system.
struct Wall {
  std::vector<int> lumen_vertex;   ///< for each vertex of the body, its number in the lumen
  std::vector<int> lumen_triangle; ///< for each triangle of the body, its number in the lumen
  const Layer* healthy_layer;      ///< intima and media, whose stretch is reported
};

/// Laws of two layers that represent plaque of a thickness (mm) and modulus (MPa) on a lumen of a radius (mm). The
/// layers lie at Gauss points in ln R, with R the distance from the axis, since the stretch falls with R. In a ring
/// four times as wide outside as inside, their energy is within 2 % of the integral through the thickness. If all
/// plaque had the lumen's strain, its energy would be 1.2 to 6.3 times as large. `law` gives yield strain, hardening
/// and Poisson's ratio.
std::array<HenckyLaw, 2> plaque_layers(const HenckyLaw& law, double modulus, double thickness, double radius);

/// Adds the wall to an empty system. Throws InputError if no triangle of the wall may move.
/// @param may_move whether each lumen vertex may move; vertices of caps never move
/// @param map_pa mean blood pressure, Pa
Wall add_wall(System& system, const Lumen& lumen, const std::vector<char>& may_move, const WallSpec& spec,
              double map_pa);

/// Positions (mm) of all lumen points: current ones for the wall's vertices, original ones for all others.
Vectors current_lumen_points(const Lumen& lumen, const Wall& wall, const System& system);

} // namespace vci
