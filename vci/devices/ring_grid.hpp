// Grids of rings along an axis, the meshes of balloons and stents.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/surface.hpp"
#include "vci/mechanics/system.hpp"

namespace vci {

/// Rings of `ring_size` vertices each. Vertex k of ring r has the number r * ring_size + k.
struct RingGrid {
  int ring_size = 0;
  std::vector<double> s;           ///< place of each ring along the straight device, from its centre, mm
  std::vector<double> profile;     ///< inflated diameter of each ring over that of the device's cylindrical part
  std::vector<double> start_ratio; ///< diameter of each ring at the start over the crimped diameter
  int rings() const { return static_cast<int>(s.size()); }
  Triangles triangles() const; ///< indices of vertices; the triangles face outwards
  /// Arc lengths (mm) of the rings along a vessel, with the device's centre at `centre_s`.
  std::vector<double> ring_arc_lengths(double centre_s) const;
};

/// The even number (at least 12) of edges of about `edge_mm` round a circumference.
int even_edge_count(double circumference_mm, double edge_mm);

/// Vertices (mm) of a grid.
/// @param frames place and axes of each ring
/// @param radius radius of each ring, mm
Vectors place_grid(const RingGrid& grid, const std::vector<Frame>& frames, const std::vector<double>& radius);
/// Vertices (mm) of a grid along the z axis. Each ring has the radius `radius` (mm) times the ring's profile.
Vectors straight_grid(const RingGrid& grid, double radius);

/// Edges round the rings, ring by ring, as pairs of the grid's vertices.
std::vector<std::array<int, 2>> hoop_edges(const RingGrid& grid);
/// Axial length (mm) of the device that each ring represents.
std::vector<double> ring_widths(const RingGrid& grid);

/// Radius (mm) of the circle with the area that each ring encloses.
std::vector<double> ring_radii(const System& system, int body, const RingGrid& grid);
/// Diameter (mm) of each ring by its perimeter: the diameter of the circle round a regular polygon with this perimeter.
std::vector<double> perimeter_diameters(const System& system, int body, const RingGrid& grid);
/// Area (mm^2) of the device's cross-section at each ring. The area that the ring encloses is projected along the line
/// through the rings' centres, since a ring may be oblique to this line.
std::vector<double> ring_section_areas(const System& system, int body, const RingGrid& grid);
Vectors ring_centres(const System& system, int body, const RingGrid& grid);

/// Changes indices within a body into indices within the system, where the body's first vertex is `first`.
void offset_vertices(std::vector<InteriorEdge>& edges, int first);
/// Puts `first` zero vectors before a body's points, so that the system's vertex indices fit the result.
Vectors with_leading_zeros(const Vectors& points, int first);

} // namespace vci
