#include "vci/ring_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vci {

namespace {

constexpr double pi = std::numbers::pi;

} // namespace

Triangles RingGrid::triangles() const {
  Triangles list;
  for (int r = 0; r + 1 < rings(); ++r)
    for (int k = 0; k < around; ++k) {
      const int a = r * around + k, b = r * around + (k + 1) % around, c = a + around, d = b + around;
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

int even_count(double circumference, double edge) {
  return 2 * std::max(6, static_cast<int>(std::lround(0.5 * circumference / edge)));
}

Vectors place_grid(const RingGrid& grid, const std::vector<Frame>& frames, const std::vector<double>& radius) {
  Vectors points;
  for (int r = 0; r < grid.rings(); ++r)
    for (int k = 0; k < grid.around; ++k) {
      const double angle = 2 * pi * k / grid.around;
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
    for (int k = 0; k < g.around; ++k)
      edges.push_back({r * g.around + k, r * g.around + (k + 1) % g.around});
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
    for (int k = 0; k < grid.around; ++k)
      sum += system.x[first + r * grid.around + k];
    centres.push_back(sum / grid.around);
  }
  return centres;
}

std::vector<double> ring_radii(const System& system, int body, const RingGrid& grid) {
  const Vectors centres = ring_centres(system, body, grid);
  const int first = system.body(body).first;
  std::vector<double> radii;
  for (int r = 0; r < grid.rings(); ++r) {
    Vec3 area = Vec3::Zero();
    for (int k = 0; k < grid.around; ++k)
      area += 0.5 * (system.x[first + r * grid.around + k] - centres[r])
                        .cross(system.x[first + r * grid.around + (k + 1) % grid.around] - centres[r]);
    radii.push_back(std::sqrt(2 * area.norm() / (grid.around * std::sin(2 * pi / grid.around))));
  }
  return radii;
}

void shift(std::vector<EdgePair>& edges, int first) {
  for (EdgePair& e : edges)
    for (int* v : {&e.e0, &e.e1, &e.w0, &e.w1})
      *v += first;
}

Vectors shifted(const Vectors& points, int first) {
  Vectors all(first, Vec3::Zero());
  all.insert(all.end(), points.begin(), points.end());
  return all;
}

} // namespace vci
