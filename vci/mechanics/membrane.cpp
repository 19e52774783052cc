#include "vci/mechanics/membrane.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace vci {

namespace {

using Mat32 = Eigen::Matrix<double, 3, 2>;

/// Principal stretches of a deformation gradient and their squares, with their directions in the reference state
/// (columns of v) and in the current state (columns of u).
struct PrincipalStretches {
  Vec2 stretch, squared_stretch;
  Mat2 v;
  Mat32 u;
};

Mat32 edge_matrix(const Triangle& t, const Vectors& x) {
  Mat32 ds;
  ds.col(0) = x[t[1]] - x[t[0]];
  ds.col(1) = x[t[2]] - x[t[0]];
  return ds;
}

/// The unit eigenvector of the larger eigenvalue of the matrix [a b; b d], found without trigonometric functions.
std::array<double, 2> principal_direction(double a, double b, double d) {
  const double difference = a - d, length = std::sqrt(difference * difference + 4 * b * b);
  if (length == 0)
    return {1, 0};
  if (difference >= 0) { // half-angle formulas that divide by the larger of cosine and sine
    const double c = std::sqrt(0.5 * (1 + difference / length));
    return {c, b / (length * c)};
  }
  const double s = std::copysign(std::sqrt(0.5 * (1 - difference / length)), b);
  return {b / (length * s), s};
}

PrincipalStretches principal_stretches(const Mat32& f) {
  // Smaller stretches are raised to this one, so that a collapsed triangle has a finite state and still resists
  // strongly.
  constexpr double smallest_stretch = 1e-3;
  const double a = f.col(0).squaredNorm(), b = f.col(0).dot(f.col(1)), d = f.col(1).squaredNorm();
  const auto [c, s] = principal_direction(a, b, d);
  PrincipalStretches p;
  p.v << c, -s, s, c;
  const Mat32 fv = f * p.v;
  for (int i = 0; i < 2; ++i) {
    p.squared_stretch[i] = std::max(fv.col(i).squaredNorm(), smallest_stretch * smallest_stretch);
    p.stretch[i] = std::sqrt(p.squared_stretch[i]);
    p.u.col(i) = fv.col(i) / p.stretch[i];
  }
  return p;
}

/// Second derivatives of the energy by the deformation gradient F, in the frame of the principal directions. They
/// belong to two scalings, to twist and shear in the plane, and to two motions out of the plane. Without `exact`,
/// negative eigenvalues are left out.
struct EnergyHessian {
  Mat2 scaling;                       ///< second derivatives by the principal stretches
  double with_itself, with_transpose; ///< second derivatives by F_ij twice, and by F_ij and F_ji, i != j
  Vec2 out_of_plane;                  ///< second derivative by the motion out of plane along each direction
};

EnergyHessian energy_hessian(const PrincipalStretches& p, const HenckyLaw::Response& r, const Vec2& sigma, bool exact) {
  const auto clamped = [exact](double value) { return exact ? value : std::max(value, 0.0); };
  EnergyHessian c;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      c.scaling(i, j) = (r.tangent(i, j) - (i == j ? r.stress[i] : 0.0)) / (p.stretch[i] * p.stretch[j]);
  const double difference = p.stretch[0] - p.stretch[1];
  const double shear =
      clamped(std::abs(difference) > 1e-6 ? (sigma[0] - sigma[1]) / difference : c.scaling(0, 0) - c.scaling(0, 1));
  const double twist = clamped((sigma[0] + sigma[1]) / (p.stretch[0] + p.stretch[1]));
  c.with_itself = 0.5 * (shear + twist);
  c.with_transpose = 0.5 * (shear - twist);
  for (int i = 0; i < 2; ++i)
    c.out_of_plane[i] = clamped(sigma[i] / p.stretch[i]);
  const double trace = c.scaling.trace(), determinant = c.scaling.determinant();
  if (!exact && (determinant < 0 || trace < 0)) {
    const auto [cosine, sine] = principal_direction(c.scaling(0, 0), c.scaling(0, 1), c.scaling(1, 1));
    const Vec2 first(cosine, sine), second(-sine, cosine);
    c.scaling = clamped(first.dot(c.scaling * first)) * first * first.transpose() +
                clamped(second.dot(c.scaling * second)) * second * second.transpose();
  }
  return c;
}

} // namespace

Membrane::Membrane(const Triangles& triangles, const Vectors& reference, std::vector<HenckyLaw> laws) {
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    const Triangle& t = triangles[k];
    const Mat32 ds = edge_matrix(t, reference);
    const double area = 0.5 * ds.col(0).cross(ds.col(1)).norm();
    if (!(area > 0))
      throw std::invalid_argument("membrane triangle " + std::to_string(k) + " has no area");
    Mat2 flat; // reference edges in the triangle's plane
    const double l = ds.col(0).norm();
    flat << l, ds.col(0).dot(ds.col(1)) / l, 0, 2 * area / l;
    const Mat2 inverse = flat.inverse();
    elements_.push_back({t, {}, inverse, inverse, area, laws[k]});
  }
}

double Membrane::energy(const Vectors& x) const {
  double sum = 0;
  for (const Element& e : elements_)
    sum += e.area *
           e.law.response_at(principal_stretches(edge_matrix(e.v, x) * e.elastic_inverse_edges).squared_stretch).energy;
  return sum;
}

void Membrane::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const {
  for (const Element& e : elements_) {
    const PrincipalStretches p = principal_stretches(edge_matrix(e.v, x) * e.elastic_inverse_edges);
    const HenckyLaw::Response r = e.law.response_at(p.squared_stretch, e.flowed);
    // gradients of the shape functions in the principal frame
    Vec2 g[3];
    g[1] = p.v.transpose() * e.elastic_inverse_edges.row(0).transpose();
    g[2] = p.v.transpose() * e.elastic_inverse_edges.row(1).transpose();
    g[0] = -g[1] - g[2];
    const Vec2 sigma = r.stress.cwiseQuotient(p.stretch); // dpsi / dlambda_i
    for (int a = 0; a < 3; ++a)
      force[e.v[a]] -= e.area * (sigma[0] * g[a][0] * p.u.col(0) + sigma[1] * g[a][1] * p.u.col(1));
    if (!stiffness)
      continue;
    const EnergyHessian c = energy_hessian(p, r, sigma, exact);
    const Vec3 u0 = p.u.col(0), u1 = p.u.col(1), normal = u0.cross(u1);
    const auto block = [&](const Vec2& ga, const Vec2& gb) -> Mat3 {
      const double g00 = e.area * ga[0] * gb[0], g01 = e.area * ga[0] * gb[1];
      const double g10 = e.area * ga[1] * gb[0], g11 = e.area * ga[1] * gb[1];
      const Vec3 row0 =
          (c.scaling(0, 0) * g00 + c.with_itself * g11) * u0 + (c.scaling(0, 1) * g01 + c.with_transpose * g10) * u1;
      const Vec3 row1 =
          (c.scaling(0, 1) * g10 + c.with_transpose * g01) * u0 + (c.scaling(1, 1) * g11 + c.with_itself * g00) * u1;
      const Vec3 row2 = (c.out_of_plane[0] * g00 + c.out_of_plane[1] * g11) * normal;
      return u0 * row0.transpose() + u1 * row1.transpose() + normal * row2.transpose();
    };
    // blocks of the upper half, with the corners in ascending order of their vertices
    const auto& corner = e.slots.order();
    const Vec2 &g1 = g[corner[1]], &g2 = g[corner[2]];
    Mat3 k[3][3];
    k[1][1] = block(g1, g1);
    k[1][2] = block(g1, g2);
    k[2][2] = block(g2, g2);
    k[0][1] = -k[1][1] - k[1][2].transpose(); // because a shift of the whole triangle causes no force
    k[0][2] = -k[1][2] - k[2][2];
    k[0][0] = -k[0][1] - k[0][2];
    e.slots.add_upper(*stiffness, k);
  }
}

void Membrane::declare_stencils(BlockPattern& pattern) const {
  for (const Element& e : elements_)
    pattern.add(e.v);
}

void Membrane::locate_blocks(const BlockMatrix& matrix) {
  for (Element& e : elements_) {
    e.slots = {matrix, e.v};
    e.flowed = false; // bodies were added or removed, so plastic flow may not continue
  }
}

void Membrane::commit(const Vectors& x) {
  for (Element& e : elements_) {
    if (std::isinf(e.law.yield_strain))
      continue;
    const PrincipalStretches p = principal_stretches(edge_matrix(e.v, x) * e.elastic_inverse_edges);
    e.flowed = e.law.yields_at(p.squared_stretch);
    if (!e.flowed)
      continue;
    const Vec2 flow = e.law.flow(0.5 * p.squared_stretch.array().log());
    e.elastic_inverse_edges = e.elastic_inverse_edges * p.v *
                              Eigen::DiagonalMatrix<double, 2>(std::exp(-flow[0]), std::exp(-flow[1])) *
                              p.v.transpose();
  }
}

int Membrane::count_yielding(const Vectors& x) const {
  int count = 0;
  for (const Element& e : elements_)
    count +=
        e.law.response_at(principal_stretches(edge_matrix(e.v, x) * e.elastic_inverse_edges).squared_stretch).yields;
  return count;
}

std::vector<double> Membrane::largest_stretch(const Vectors& x) const {
  std::vector<double> stretch;
  for (const Element& e : elements_)
    stretch.push_back(principal_stretches(edge_matrix(e.v, x) * e.inverse_edges).stretch.maxCoeff());
  return stretch;
}

} // namespace vci
