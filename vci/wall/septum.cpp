#include "vci/wall/septum.hpp"
#include "vci/geometry/broad_phase.hpp"
#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace vci {

namespace {

constexpr double least_volume_ratio = 0.2; // below this J the logarithm is continued
// Lumens further apart than this many walls are not joined: the tissue between them is as soft as that round a vessel,
// which the ring foundation has already.
constexpr double largest_distance_in_walls = 5;
// Least cosine between a vertex's normal, or that of the triangle behind it, and the line that joins them. Elements
// more oblique than this are slivers.
constexpr double least_cosine = 0.3;

/// ln J and its first two derivatives.
struct Logarithm {
  double value, slope, curvature;
};

Logarithm continued_logarithm(double j) {
  constexpr double j0 = least_volume_ratio;
  if (j >= j0)
    return {std::log(j), 1 / j, -1 / (j * j)};
  const double r = (j - j0) / j0;
  return {std::log(j0) + r - 0.5 * r * r, (1 - r) / j0, -1 / (j0 * j0)};
}

Mat3 edges_from_first(const std::array<int, 4>& vertex, const Vectors& x) {
  Mat3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = x[vertex[k + 1]] - x[vertex[0]];
  return edges;
}

/// dJ/dF.
Mat3 cofactor(const Mat3& f) {
  Mat3 c;
  c.col(0) = f.col(1).cross(f.col(2));
  c.col(1) = f.col(2).cross(f.col(0));
  c.col(2) = f.col(0).cross(f.col(1));
  return c;
}

/// Reference gradients of the shape functions of the four vertices, 1/mm.
std::array<Vec3, 4> shape_gradients(const Mat3& inverse_edges) {
  std::array<Vec3, 4> gradient;
  for (int k = 0; k < 3; ++k)
    gradient[k + 1] = inverse_edges.row(k).transpose();
  gradient[0] = -(gradient[1] + gradient[2] + gradient[3]);
  return gradient;
}

/// The matrix of the cross product: a x b = cross_matrix(a) b.
Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

} // namespace

Septum::Septum(std::vector<Element> elements, double poisson_ratio)
    : elements_(std::move(elements)), shear_share_(0.5 / (1 + poisson_ratio)),
      lambda_share_(poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))) {}

double Septum::energy(const Vectors& x) const {
  double sum = 0;
  for (const Element& element : elements_) {
    const Mat3 f = edges_from_first(element.vertex, x) * element.inverse_edges;
    const double mu = shear_share_ * element.modulus, lambda = lambda_share_ * element.modulus;
    const double logarithm = continued_logarithm(f.determinant()).value;
    sum += element.volume * (0.5 * mu * (f.squaredNorm() - 3) - mu * logarithm + 0.5 * lambda * logarithm * logarithm);
  }
  return sum;
}

void Septum::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const {
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const Element& element = elements_[k];
    const Mat3 f = edges_from_first(element.vertex, x) * element.inverse_edges, df_volume = cofactor(f);
    const double mu = shear_share_ * element.modulus, lambda = lambda_share_ * element.modulus;
    const Logarithm log = continued_logarithm(f.determinant());
    const double by_volume = (lambda * log.value - mu) * log.slope; // derivative of the energy by J
    const Mat3 stress = mu * f + by_volume * df_volume;             // first Piola-Kirchhoff stress, MPa
    const std::array<Vec3, 4> gradient = shape_gradients(element.inverse_edges);
    std::array<Vec3, 4> volume_gradient; // dJ/dx of each vertex, 1/mm
    for (int i = 0; i < 4; ++i) {
      force[element.vertex[i]] -= element.volume * (stress * gradient[i]);
      volume_gradient[i] = df_volume * gradient[i];
    }
    if (!stiffness)
      continue;
    // second derivative of the energy by J
    double second = lambda * log.slope * log.slope + (lambda * log.value - mu) * log.curvature;
    if (!exact)
      second = std::max(second, 0.0);
    slots_[k].add(*stiffness, [&](int i, int j) -> Mat3 {
      Mat3 block = second * volume_gradient[i] * volume_gradient[j].transpose();
      block.diagonal().array() += mu * gradient[i].dot(gradient[j]);
      if (exact) // the second derivative of J, which has negative eigenvalues
        block += by_volume * cross_matrix(f * gradient[j].cross(gradient[i]));
      return element.volume * block;
    });
  }
}

void Septum::declare_stencils(BlockPattern& pattern) const {
  for (const Element& element : elements_)
    pattern.add(element.vertex);
}

void Septum::locate_blocks(const BlockMatrix& matrix) {
  slots_.clear();
  for (const Element& element : elements_)
    slots_.emplace_back(matrix, element.vertex);
}

double SeptumTissue::modulus(double thickness) const {
  const double walls = std::min(2 * wall_thickness, thickness), between = thickness - walls;
  return between > 0 ? thickness / (walls / wall_modulus + between / tissue_modulus) : wall_modulus;
}

namespace {

/// The triangle behind a vertex.
struct TriangleBehind {
  int triangle = -1;       ///< -1: none
  double distance, height; ///< of the vertex from the triangle's closest point and from its plane, mm
};

/// @param own_branches branches of the triangles at the vertex
TriangleBehind triangle_behind(int vertex, const Vec3& normal, const std::set<int>& own_branches,
                               const std::vector<NearTriangle>& near, const Triangles& triangles,
                               const std::vector<int>& branch, const Vectors& points) {
  constexpr double same_distance = 1e-9; // mm: triangles that share the closest point
  TriangleBehind best{-1, std::numeric_limits<double>::infinity(), 0};
  for (const NearTriangle& n : near) {
    const Triangle& t = triangles[n.triangle];
    if (own_branches.contains(branch[n.triangle]) || n.distance > best.distance + same_distance)
      continue;
    const Vec3 towards =
        n.weights[0] * points[t[0]] + n.weights[1] * points[t[1]] + n.weights[2] * points[t[2]] - points[vertex];
    const Vec3 other = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized();
    const double height = -other.dot(towards), least = least_cosine * n.distance;
    if (other.dot(normal) > 0 || height <= least || normal.dot(towards) <= least)
      continue;
    if (n.distance < best.distance - same_distance || height > best.height)
      best = {n.triangle, n.distance, height};
  }
  return best;
}

} // namespace

std::vector<Septum::Element> septum_elements(const Triangles& triangles, const Vectors& points,
                                             const std::vector<int>& branch, const SeptumTissue& tissue) {
  std::vector<Septum::Element> elements;
  if (branch.empty())
    return elements;
  std::vector<std::set<int>> own_branches(points.size());
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (int v : triangles[k])
      own_branches[v].insert(branch[k]);
  const Vectors areas = vertex_area_vectors(triangles, points, 0, static_cast<int>(points.size()));
  const double reach = largest_distance_in_walls * tissue.wall_thickness;
  const BroadPhase boxes(triangles, points);
  std::vector<NearTriangle> near;
  for (int v = 0; v < static_cast<int>(points.size()); ++v) {
    boxes.find_near(points[v], triangles, points, reach, reach, -1, near);
    const TriangleBehind behind =
        triangle_behind(v, areas[v].normalized(), own_branches[v], near, triangles, branch, points);
    if (behind.triangle < 0)
      continue;
    const Triangle& t = triangles[behind.triangle];
    const double modulus = tissue.modulus(behind.height);
    if (!(modulus > 0))
      continue;
    const std::array<int, 4> vertex{v, t[0], t[1], t[2]};
    elements.push_back(
        {vertex, edges_from_first(vertex, points).inverse(), 0.5 * areas[v].norm() * behind.height, modulus});
  }
  return elements;
}

} // namespace vci
