#include "vci/wall/mass_spring.hpp"
#include "vci/geometry/surface.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <stdexcept>

namespace vci {

namespace {

/// The two edges of a triangle from its corner 0 (columns, mm), in an orthonormal basis of the triangle's plane.
Mat2 edges_in_plane(const Triangle& t, const Vectors& x) {
  const Vec3 u = x[t[1]] - x[t[0]], v = x[t[2]] - x[t[0]];
  const double l = u.norm();
  Mat2 flat;
  flat << l, u.dot(v) / l, 0, u.cross(v).norm() / l;
  return flat;
}

} // namespace

std::array<double, 3> spring_stiffness(const std::array<Vec3, 3>& x, double modulus, double nu, SpringMapping mapping) {
  const double lambda = modulus * nu / (1 - nu * nu), mu = modulus / (2 * (1 + nu));
  std::array<double, 3> stiffness;
  for (int i = 0; i < 3; ++i) {
    const Vec3 u = x[(i + 1) % 3] - x[i], v = x[(i + 2) % 3] - x[i];
    const double area = 0.5 * u.cross(v).norm(), square = (u - v).squaredNorm(), cot = u.dot(v) / (2 * area);
    stiffness[i] = mapping == SpringMapping::van_gelder ? modulus * area / square
                                                        : square * (2 * cot * cot * (lambda + mu) + mu) / (8 * area);
  }
  return stiffness;
}

MassSpring::MassSpring(const Triangles& triangles, const Vectors& reference, const std::vector<HenckyLaw>& laws,
                       SpringMapping mapping)
    : triangles_(triangles) {
  std::map<std::array<int, 2>, double> edge_stiffness;
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    const Triangle& t = triangles[k];
    if (!(area_vector(t, reference).norm() > 0))
      throw std::invalid_argument("spring triangle " + std::to_string(k) + " has no area");
    inverse_edges_.push_back(edges_in_plane(t, reference).inverse());
    const HenckyLaw& law = laws[k];
    const auto stiffness = spring_stiffness({reference[t[0]], reference[t[1]], reference[t[2]]}, law.stiffness,
                                            law.poisson_ratio, mapping);
    for (int i = 0; i < 3; ++i) {
      const int a = std::min(t[(i + 1) % 3], t[(i + 2) % 3]), b = std::max(t[(i + 1) % 3], t[(i + 2) % 3]);
      add_edge(a, b);
      edge_stiffness[{a, b}] += stiffness[i];
      springs_.push_back({stiffness[i], (reference[b] - reference[a]).norm(), 0, 1, 1, law.stiffening, law.yield_strain,
                          law.hardening, law.depth});
    }
  }
  for (std::size_t k = 0; k < springs_.size(); ++k)
    springs_[k].edge_stiffness = edge_stiffness[edges_[k]];
}

double MassSpring::Spring::layer_strain(double length) const {
  const double stretch = length / (rest_length * plastic_stretch);
  return std::sqrt((stretch * stretch + depth) / (1 + depth)) - 1;
}

EdgeForce::Tension MassSpring::tension(std::size_t k, double length) const {
  const Spring& s = springs_[k];
  const double e = s.layer_strain(length), w = std::abs(e);
  double energy, slope, curvature; // psi, and its first and second derivative by e
  if (w > s.yield_strain) {
    const double excess = w - s.yield_strain;
    energy = 0.5 * s.yield_strain * s.yield_strain + s.yield_strain * excess + 0.5 * s.hardening * excess * excess;
    slope = std::copysign(s.elastic_part(w), e);
    curvature = s.hardening;
  } else {
    energy = 0.5 * e * e + 0.25 * s.stiffening * e * e * e * e;
    slope = e + s.stiffening * e * e * e;
    curvature = 1 + 3 * s.stiffening * e * e;
  }
  const double to_stretch = 1 / (s.rest_length * s.plastic_stretch), stretch = length * to_stretch;
  const double layer = 1 + e, share = 1 + s.depth;
  const double first = stretch / (layer * share) * to_stretch;
  const double second = s.depth / (layer * layer * layer * share * share) * to_stretch * to_stretch;
  const double scale = s.stiffness * s.rest_length * s.rest_length * s.layer_plastic_stretch;
  return {scale * energy, scale * slope * first, scale * (curvature * first * first + slope * second)};
}

void MassSpring::commit(const Vectors& x) {
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    Spring& s = springs_[k];
    const double e = s.layer_strain(length(k, x)), w = std::abs(e);
    if (w <= s.yield_strain)
      continue;
    // As in HenckyLaw::flow(), the depth is relative to the lumen's radius, which may have grown permanently.
    const double stretch = length(k, x) / (s.rest_length * s.plastic_stretch);
    const double elastic = 1 + std::copysign(s.elastic_part(w), e), permanent = (1 + e) / elastic;
    s.yield_strain = s.elastic_part(w);
    s.depth /= permanent > 1 ? permanent * permanent * (1 + s.depth) - s.depth : 1;
    s.layer_plastic_stretch *= permanent; // so that the force stays the same
    s.plastic_stretch *= stretch / std::sqrt(elastic * elastic * (1 + s.depth) - s.depth);
  }
}

void MassSpring::add_damping(const Vectors& x, const std::vector<double>& mass, double rate,
                             BlockMatrix& matrix) const {
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    const Spring& s = springs_[k];
    const auto [i, j] = edges_[k];
    const Vec3 e = (x[j] - x[i]).normalized();
    const double c = 2 * s.stiffness * std::sqrt(0.5 * (mass[i] + mass[j]) / s.edge_stiffness);
    add_edge_stiffness(matrix, k, rate * c * e * e.transpose());
  }
}

std::vector<double> MassSpring::largest_stretch(const Vectors& x) const {
  std::vector<double> stretch;
  for (std::size_t k = 0; k < triangles_.size(); ++k) {
    const Mat2 f = edges_in_plane(triangles_[k], x) * inverse_edges_[k], c = f.transpose() * f;
    stretch.push_back(std::sqrt(0.5 * c.trace() + std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1))));
  }
  return stretch;
}

int MassSpring::count_yielding(const Vectors& x) const {
  int count = 0;
  for (std::size_t k = 0; k < springs_.size(); ++k)
    count += std::abs(springs_[k].layer_strain(length(k, x))) > springs_[k].yield_strain;
  return count;
}

} // namespace vci
