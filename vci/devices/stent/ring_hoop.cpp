#include "vci/devices/stent/ring_hoop.hpp"

#include <cmath>

namespace vci {

namespace {

double ring_length(const std::vector<int>& ring, const Vectors& x) {
  double length = 0;
  for (std::size_t k = 0; k < ring.size(); ++k)
    length += (x[ring[(k + 1) % ring.size()]] - x[ring[k]]).norm();
  return length;
}

struct Tension {
  double energy, force, tangent; ///< N mm, N, N/mm
};

/// After plastic flow the strain |e| equals the yield strain, up to rounding errors smaller than this. Rounding must
/// not choose between the elastic and the plastic tangent. With the plastic one, the first step of a ring that is
/// unloaded would be far too long.
constexpr double yield_rounding = 1e-9;

Tension tension(const RingHoops::Ring& r, double length) {
  const double e = length / r.rest_length - 1, y = r.yield_strain, excess = std::abs(e) - y;
  if (excess <= (r.flow_sign != 0 && r.flow_sign * e > 0 ? -yield_rounding : yield_rounding))
    return {0.5 * r.stiffness * r.rest_length * e * e, r.stiffness * e, r.stiffness / r.rest_length};
  return {r.stiffness * r.rest_length * (0.5 * y * y + y * excess + 0.5 * r.hardening * excess * excess),
          std::copysign(r.stiffness * (y + r.hardening * excess), e), r.stiffness * r.hardening / r.rest_length};
}

} // namespace

double RingHoops::energy(const Vectors& x) const {
  double sum = 0;
  for (const Ring& r : rings_)
    sum += tension(r, ring_length(r.vertices, x)).energy;
  return sum;
}

void RingHoops::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool) const {
  std::size_t edge = 0;
  for (const Ring& r : rings_) {
    const std::size_t n = r.vertices.size();
    const Tension t = tension(r, ring_length(r.vertices, x));
    RankOne term{r.vertices, Vectors(n, Vec3::Zero()), t.tangent};
    for (std::size_t k = 0; k < n; ++k, ++edge) {
      const int i = r.vertices[k], j = r.vertices[(k + 1) % n];
      const Vec3 d = x[j] - x[i];
      const double l = d.norm();
      const Vec3 e = d / l;
      force[i] += t.force * e;
      force[j] -= t.force * e;
      if (!stiffness)
        continue;
      term.gradient[k] -= e;
      term.gradient[(k + 1) % n] += e;
      const double across = std::max(t.force / l, 0.0);
      Mat3 h = -across * e * e.transpose();
      h.diagonal().array() += across;
      slots_[edge].add(*stiffness, [&](int a, int b) -> Mat3 { return a == b ? h : -h; });
    }
    if (stiffness)
      stiffness->add(std::move(term));
  }
}

void RingHoops::declare_stencils(BlockPattern& pattern) const {
  for (const Ring& r : rings_)
    for (std::size_t k = 0; k < r.vertices.size(); ++k)
      pattern.add(std::array<int, 2>{r.vertices[k], r.vertices[(k + 1) % r.vertices.size()]});
}

void RingHoops::locate_blocks(const BlockMatrix& matrix) {
  slots_.clear();
  for (Ring& r : rings_) {
    r.flow_sign = 0; // bodies were added or removed, so plastic flow may not continue
    for (std::size_t k = 0; k < r.vertices.size(); ++k)
      slots_.emplace_back(matrix, std::array<int, 2>{r.vertices[k], r.vertices[(k + 1) % r.vertices.size()]});
  }
}

void RingHoops::commit(const Vectors& x) {
  for (Ring& r : rings_) {
    const double length = ring_length(r.vertices, x), e = length / r.rest_length - 1;
    const double excess = std::abs(e) - r.yield_strain;
    r.flow_sign = 0;
    if (excess > 0) {
      r.flow_sign = e > 0 ? 1 : -1;
      r.yield_strain += r.hardening * excess;
      r.rest_length = length / (1 + std::copysign(r.yield_strain, e));
    }
  }
}

bool RingHoops::stop_reversed_flow(const Vectors& x, const Vectors& dx) {
  bool stopped = false;
  for (Ring& r : rings_) {
    if (r.flow_sign == 0)
      continue;
    double change = 0;
    for (std::size_t k = 0; k < r.vertices.size(); ++k) {
      const int i = r.vertices[k], j = r.vertices[(k + 1) % r.vertices.size()];
      change += (dx[j] - dx[i]).dot(x[j] - x[i]) / (x[j] - x[i]).norm();
    }
    // Unloading by less than the yield strain does no harm, and another solve costs as much as a step.
    if (r.flow_sign * change < -r.yield_strain * r.rest_length) {
      r.flow_sign = 0;
      stopped = true;
    }
  }
  return stopped;
}

int RingHoops::count_yielding(const Vectors& x) const {
  int count = 0;
  for (const Ring& r : rings_)
    count += std::abs(ring_length(r.vertices, x) / r.rest_length - 1) > r.yield_strain;
  return count;
}

RingEvenness::RingEvenness(const std::vector<Ring>& rings) {
  for (const Ring& r : rings) {
    const std::size_t n = r.vertices.size();
    for (std::size_t k = 0; k < n; ++k)
      elements_.push_back({{r.vertices[k], r.vertices[(k + 1) % n], r.vertices[(k + 2) % n]}, r.coefficient});
  }
}

double RingEvenness::energy(const Vectors& x) const {
  double sum = 0;
  for (const Element& e : elements_) {
    const double ratio = std::log((x[e.v[1]] - x[e.v[0]]).norm() / (x[e.v[2]] - x[e.v[1]]).norm());
    sum += 0.5 * e.coefficient * ratio * ratio;
  }
  return sum;
}

void RingEvenness::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool) const {
  for (const Element& e : elements_) {
    const Vec3 a = x[e.v[1]] - x[e.v[0]], b = x[e.v[2]] - x[e.v[1]];
    const double a2 = a.squaredNorm(), b2 = b.squaredNorm();
    const double ratio = 0.5 * std::log(a2 / b2);
    const std::array<Vec3, 3> g{-a / a2, a / a2 + b / b2, -b / b2}; // gradient of the ratio by the three vertices
    for (int i = 0; i < 3; ++i)
      force[e.v[i]] -= e.coefficient * ratio * g[i];
    if (stiffness)
      e.slots.add_rank_one(*stiffness, e.coefficient, g);
  }
}

void RingEvenness::declare_stencils(BlockPattern& pattern) const {
  for (const Element& e : elements_)
    pattern.add(e.v);
}

void RingEvenness::locate_blocks(const BlockMatrix& matrix) {
  for (Element& e : elements_)
    e.slots = {matrix, e.v};
}

} // namespace vci
