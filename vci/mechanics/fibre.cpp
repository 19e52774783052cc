#include "vci/mechanics/fibre.hpp"

#include <cmath>

namespace vci {

double EdgeForce::energy(const Vectors& x) const {
  double sum = 0;
  for (std::size_t k = 0; k < edges_.size(); ++k)
    sum += tension(k, length(k, x)).energy;
  return sum;
}

void EdgeForce::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const {
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    const auto [i, j] = edges_[k];
    const Vec3 d = x[j] - x[i];
    const double l = d.norm();
    const Vec3 e = d / l;
    const Tension t = tension(k, l);
    force[i] += t.force * e;
    force[j] -= t.force * e;
    if (!stiffness)
      continue;
    const double along = exact ? t.tangent : std::max(t.tangent, 0.0);
    const double across = exact ? t.force / l : std::max(t.force / l, 0.0);
    Mat3 h = (along - across) * e * e.transpose();
    h.diagonal().array() += across;
    add_edge_stiffness(*stiffness, k, h);
  }
}

void EdgeForce::add_edge_stiffness(BlockMatrix& matrix, std::size_t k, const Mat3& h) const {
  slots_[k].add(matrix, [&](int a, int b) -> Mat3 { return a == b ? h : -h; });
}

void EdgeForce::declare_stencils(BlockPattern& pattern) const {
  for (const auto& edge : edges_)
    pattern.add(edge);
}

void EdgeForce::locate_blocks(const BlockMatrix& matrix) {
  slots_.clear();
  for (const auto& edge : edges_)
    slots_.emplace_back(matrix, edge);
}

Fibres::Fibres(const std::vector<Fibre>& fibres) : fibres_(fibres) {
  for (const Fibre& f : fibres_)
    add_edge(f.i, f.j);
}

EdgeForce::Tension Fibres::tension(std::size_t k, double length) const {
  const Fibre& f = fibres_[k];
  const double eps = std::log(length / f.rest_length), scale = f.stiffness * f.rest_length;
  Tension t{0.5 * scale * eps * eps, scale * eps / length, scale * (1 - eps) / (length * length)};
  const double slack_strain = -f.pretension / f.stiffness; // strain at which the tension is 0, to first order
  if (f.slack && eps < slack_strain) {
    const double slack_share = 0.02, excess = eps - slack_strain;
    const double stress = slack_strain + slack_share * excess;
    t = {scale * (0.5 * slack_strain * slack_strain + slack_strain * excess + 0.5 * slack_share * excess * excess),
         scale * stress / length, scale * (slack_share - stress) / (length * length)};
  }
  t.energy += f.pretension * length;
  t.force += f.pretension;
  return t;
}

void Fibres::set_pretension(const std::vector<double>& tension) {
  for (std::size_t k = 0; k < fibres_.size(); ++k)
    fibres_[k].pretension = tension[k];
}

} // namespace vci
