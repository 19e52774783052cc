// Forces that act on single vertices, and springs that anchor vertices.
#pragma once
#include "vci/mechanics/force.hpp"

namespace vci {

/// Forces on single vertices; their stiffness has only diagonal blocks.
class VertexForce : public Force {
public:
  void declare_stencils(BlockPattern& pattern) const override;
  void locate_blocks(const BlockMatrix& matrix) override;

protected:
  explicit VertexForce(std::vector<int> vertices) : vertices_(std::move(vertices)) {}
  std::vector<int> vertices_, slots_;
};

/// Springs that hold vertices near fixed places, as a device's shaft does.
class Anchors : public VertexForce {
public:
  struct Element {
    int vertex;
    Vec3 rest_position; ///< where the spring is at rest, mm
    double stiffness;   ///< N/mm
  };
  explicit Anchors(std::vector<Element> elements);

  double energy(const Vectors& x) const override;
  void evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const override;

private:
  std::vector<Element> elements_;
};

} // namespace vci
