#include "vci/mechanics/vertex_force.hpp"

namespace vci {

void VertexForce::declare_stencils(BlockPattern& pattern) const {
  for (int v : vertices_)
    pattern.add(std::array<int, 1>{v});
}

void VertexForce::locate_blocks(const BlockMatrix& matrix) {
  slots_.clear();
  for (int v : vertices_)
    slots_.push_back(matrix.diagonal_slot(v));
}

namespace {

template <class Element> std::vector<int> vertices_of(const std::vector<Element>& elements) {
  std::vector<int> vertices;
  for (const Element& e : elements)
    vertices.push_back(e.vertex);
  return vertices;
}

} // namespace

Anchors::Anchors(std::vector<Element> elements) : VertexForce(vertices_of(elements)), elements_(std::move(elements)) {}

double Anchors::energy(const Vectors& x) const {
  double sum = 0;
  for (const Element& e : elements_)
    sum += 0.5 * e.stiffness * (x[e.vertex] - e.rest_position).squaredNorm();
  return sum;
}

void Anchors::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool) const {
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const Element& e = elements_[k];
    force[e.vertex] -= e.stiffness * (x[e.vertex] - e.rest_position);
    if (stiffness)
      stiffness->block(slots_[k]).diagonal().array() += e.stiffness;
  }
}

} // namespace vci
