#include "vci/mechanics/hinge.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace vci {

Dihedral dihedral(const Vec3& e0, const Vec3& e1, const Vec3& left, const Vec3& right) {
  const Vec3 e = e1 - e0;
  const double l2 = e.squaredNorm(), l = std::sqrt(l2);
  const Vec3 n1 = e.cross(left - e0), n2 = (right - e0).cross(e);
  Dihedral d;
  d.angle = std::atan2(n1.cross(n2).dot(e) / l, n1.dot(n2));
  const Vec3 g2 = -l / n1.squaredNorm() * n1, g3 = -l / n2.squaredNorm() * n2;
  const double t2 = (left - e0).dot(e) / l2, t3 = (right - e0).dot(e) / l2;
  // Rigid motions do not change the angle, so g2 and g3 determine the gradients at the ends of the edge. How they are
  // shared depends on where each triangle's height meets the edge.
  d.gradient = {-(1 - t2) * g2 - (1 - t3) * g3, -t2 * g2 - t3 * g3, g2, g3};
  return d;
}

namespace {

template <class Element> Dihedral dihedral_of(const Element& e, const Vectors& x) {
  return dihedral(x[e.v[0]], x[e.v[1]], x[e.v[2]], x[e.v[3]]);
}

/// The angle (rad) brought into the range from -pi to pi by whole turns.
double wrapped_angle(double angle) {
  return std::abs(angle) <= pi ? angle : std::remainder(angle, 2 * pi);
}

} // namespace

std::vector<double> shell_coefficients(const std::vector<InteriorEdge>& edges, const Vectors& reference,
                                       double rigidity) {
  std::vector<double> coefficients;
  for (const InteriorEdge& edge : edges) {
    const double area = area_vector({edge.e0, edge.e1, edge.w0}, reference).norm() +
                        area_vector({edge.e1, edge.e0, edge.w1}, reference).norm();
    coefficients.push_back(3.0 * rigidity * edge.rest_length * edge.rest_length / area);
  }
  return coefficients;
}

Hinges::Hinges(const std::vector<InteriorEdge>& edges, const Vectors& reference,
               const std::vector<double>& coefficients, const std::vector<double>& yield_angles) {
  for (std::size_t k = 0; k < edges.size(); ++k) {
    Element e{{edges[k].e0, edges[k].e1, edges[k].w0, edges[k].w1}, {}, coefficients[k], yield_angles[k], 0};
    e.rest_angle = dihedral_of(e, reference).angle;
    elements_.push_back(e);
  }
}

double Hinges::energy(const Vectors& x) const {
  double sum = 0;
  for (const Element& e : elements_) {
    const double bend = wrapped_angle(dihedral_of(e, x).angle - e.rest_angle);
    sum += 0.5 * e.coefficient * bend * bend;
  }
  return sum;
}

void Hinges::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool) const {
  for (const Element& e : elements_) {
    const Dihedral d = dihedral_of(e, x);
    const double bend = wrapped_angle(d.angle - e.rest_angle);
    for (int a = 0; a < 4; ++a)
      force[e.v[a]] -= e.coefficient * bend * d.gradient[a];
    if (stiffness)
      e.slots.add_rank_one(*stiffness, e.coefficient, d.gradient);
  }
}

void Hinges::declare_stencils(BlockPattern& pattern) const {
  for (const Element& e : elements_)
    pattern.add(e.v);
}

void Hinges::locate_blocks(const BlockMatrix& matrix) {
  for (Element& e : elements_)
    e.slots = {matrix, e.v};
}

void Hinges::commit(const Vectors& x) {
  for (Element& e : elements_) {
    if (e.yield_angle >= pi)
      continue;
    const double bend = wrapped_angle(dihedral_of(e, x).angle - e.rest_angle);
    if (std::abs(bend) > e.yield_angle)
      e.rest_angle = wrapped_angle(e.rest_angle + bend - std::copysign(e.yield_angle, bend));
  }
}

} // namespace vci
