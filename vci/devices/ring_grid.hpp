// Grids of rings along an axis, the meshes of balloons and stents.
#pragma once
#include "vci/geometry/centreline.hpp"
#include "vci/geometry/surface.hpp"
#include "vci/mechanics/system.hpp"

namespace vci {

/// Rings of `around` vertices each; vertex (ring, k) is ring * around + k.
struct RingGrid {
  int around = 0;
  std::vector<double> s;       ///< along the straight device, from its centre, mm
  std::vector<double> profile; ///< each ring's diameter over the body's
  std::vector<double> start;   ///< each ring's diameter at the start over the crimped diameter
  int rings() const { return static_cast<int>(s.size()); }
  Triangles triangles() const; ///< outward
  /// Arc lengths (mm) of the rings along a vessel, with the device's centre at `centre_s`.
  std::vector<double> along(double centre_s) const;
};

/// An even number (at least 12) of edges about `edge_mm` long round a circumference.
int even_count(double circumference_mm, double edge_mm);

/// Vertices of a grid with the given radius at each ring.
Vectors place_grid(const RingGrid& grid, const std::vector<Frame>& frames, const std::vector<double>& radius);
/// The same along a straight axis, the radius (mm) times the grid's profile.
Vectors straight_grid(const RingGrid& grid, double radius);

/// Edges round the rings, ring by ring.
std::vector<std::array<int, 2>> hoop_edges(const RingGrid& grid);
/// Axial length (mm) of the device that each ring represents.
std::vector<double> ring_widths(const RingGrid& grid);

/// Mean radius (mm) of each ring about its own centre, from the area its polygon encloses.
std::vector<double> ring_radii(const System& system, int body, const RingGrid& grid);
/// Diameter (mm) of the circle with the same perimeter, for each ring.
std::vector<double> perimeter_diameters(const System& system, int body, const RingGrid& grid);
/// Area (mm^2) that each ring encloses, projected along the line through the rings' centres. This is the section of the
/// tube, even if the ring is oblique in it.
std::vector<double> ring_sections(const System& system, int body, const RingGrid& grid);
Vectors ring_centres(const System& system, int body, const RingGrid& grid);

/// Converts a body's own indices and positions to the system's, in which the body's first vertex is `first`.
void shift(std::vector<EdgePair>& edges, int first);
Vectors shifted(const Vectors& points, int first);

} // namespace vci
