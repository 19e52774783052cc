#include "vci/devices/ring_grid.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

/// Area vector (mm^2) of each ring. The polygon's area vector is scaled by the area of a circle over that of the
/// regular polygon inscribed in it.
Vectors ring_areas(const System& system, int body, const RingGrid& grid) {
  const Vectors centres = ring_centres(system, body, grid);
  const int first = system.body(body).first;
  const double circle_over_polygon = 2 * pi / (grid.ring_size * std::sin(2 * pi / grid.ring_size));
  Vectors areas;
  for (int r = 0; r < grid.rings(); ++r) {
    Vec3 area = Vec3::Zero();
    for (int k = 0; k < grid.ring_size; ++k)
      area += 0.5 * (system.x[first + r * grid.ring_size + k] - centres[r])
                        .cross(system.x[first + r * grid.ring_size + (k + 1) % grid.ring_size] - centres[r]);
    areas.push_back(circle_over_polygon * area);
  }
  return areas;
}

} // namespace

Triangles RingGrid::triangles() const {
  Triangles list;
  for (int r = 0; r + 1 < rings(); ++r)
    for (int k = 0; k < ring_size; ++k) {
      const int a = r * ring_size + k, b = r * ring_size + (k + 1) % ring_size, c = a + ring_size, d = b + ring_size;
      if ((r + k) % 2 == 0) {
        list.push_back({a, b, d});
        list.push_back({a, d, c});
      } else {
        list.push_back({a, b, c});
        list.push_back({b, d, c});
      }
    }
  return list;
}

std::vector<double> RingGrid::ring_arc_lengths(double centre_s) const {
  std::vector<double> arc_lengths = s;
  for (double& arc_length : arc_lengths)
    arc_length += centre_s;
  return arc_lengths;
}

int even_edge_count(double circumference, double edge) {
  return 2 * std::max(6, static_cast<int>(std::lround(0.5 * circumference / edge)));
}

Vectors place_grid(const RingGrid& grid, const std::vector<Frame>& frames, const std::vector<double>& radius) {
  Vectors points;
  for (int r = 0; r < grid.rings(); ++r)
    for (int k = 0; k < grid.ring_size; ++k) {
      const double angle = 2 * pi * k / grid.ring_size;
      points.push_back(frames[r].origin +
                       radius[r] * (std::cos(angle) * frames[r].first + std::sin(angle) * frames[r].second));
    }
  return points;
}

Vectors straight_grid(const RingGrid& g, double radius) {
  std::vector<Frame> frames;
  std::vector<double> radii;
  for (int r = 0; r < g.rings(); ++r) {
    frames.push_back({Vec3(0, 0, g.s[r]), Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()});
    radii.push_back(radius * g.profile[r]);
  }
  return place_grid(g, frames, radii);
}

std::vector<std::array<int, 2>> hoop_edges(const RingGrid& g) {
  std::vector<std::array<int, 2>> edges;
  for (int r = 0; r < g.rings(); ++r)
    for (int k = 0; k < g.ring_size; ++k)
      edges.push_back({r * g.ring_size + k, r * g.ring_size + (k + 1) % g.ring_size});
  return edges;
}

std::vector<double> ring_widths(const RingGrid& g) {
  std::vector<double> width(g.rings(), 0.0);
  for (int r = 0; r + 1 < g.rings(); ++r) {
    width[r] += 0.5 * (g.s[r + 1] - g.s[r]);
    width[r + 1] += 0.5 * (g.s[r + 1] - g.s[r]);
  }
  return width;
}

Vectors ring_centres(const System& system, int body, const RingGrid& grid) {
  Vectors centres;
  const int first = system.body(body).first;
  for (int r = 0; r < grid.rings(); ++r) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < grid.ring_size; ++k)
      sum += system.x[first + r * grid.ring_size + k];
    centres.push_back(sum / grid.ring_size);
  }
  return centres;
}

std::vector<double> ring_radii(const System& system, int body, const RingGrid& grid) {
  std::vector<double> radii;
  for (const Vec3& area : ring_areas(system, body, grid))
    radii.push_back(std::sqrt(area.norm() / pi));
  return radii;
}

std::vector<double> ring_section_areas(const System& system, int body, const RingGrid& grid) {
  const Vectors centres = ring_centres(system, body, grid), areas = ring_areas(system, body, grid);
  std::vector<double> sections;
  for (int r = 0; r < grid.rings(); ++r) {
    const Vec3 along = centres[std::min(r + 1, grid.rings() - 1)] - centres[std::max(r - 1, 0)];
    sections.push_back(std::abs(areas[r].dot(along.normalized())));
  }
  return sections;
}

std::vector<double> perimeter_diameters(const System& system, int body, const RingGrid& grid) {
  const int first = system.body(body).first;
  std::vector<double> diameters;
  for (int r = 0; r < grid.rings(); ++r) {
    double perimeter = 0;
    for (int k = 0; k < grid.ring_size; ++k)
      perimeter +=
          (system.x[first + r * grid.ring_size + (k + 1) % grid.ring_size] - system.x[first + r * grid.ring_size + k])
              .norm();
    diameters.push_back(perimeter / (grid.ring_size * std::sin(pi / grid.ring_size)));
  }
  return diameters;
}

void offset_vertices(std::vector<InteriorEdge>& edges, int first) {
  for (InteriorEdge& e : edges)
    for (int* v : {&e.e0, &e.e1, &e.w0, &e.w1})
      *v += first;
}

Vectors with_leading_zeros(const Vectors& points, int first) {
  Vectors all(first, Vec3::Zero());
  all.insert(all.end(), points.begin(), points.end());
  return all;
}

} // namespace vci
