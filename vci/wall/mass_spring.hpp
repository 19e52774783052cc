// Springs along the triangles' edges (Delingette's or Van Gelder's); not those of the source, equations 13 to 16.
#pragma once
#include "vci/mechanics/fibre.hpp"
#include "vci/mechanics/hencky_law.hpp"
#include "vci/mechanics/layer.hpp"
#include "vci/wall/spring_mapping.hpp"

namespace vci {

/// Stiffness (N/mm) of the springs along the edges opposite to corners 0, 1 and 2.
std::array<double, 3> spring_stiffness(const std::array<Vec3, 3>& corners, double modulus_times_thickness,
                                       double poisson_ratio, SpringMapping mapping);

/// Three springs per triangle, so that each keeps its triangle's yield. An edge between two triangles has two springs,
/// whose forces add. With e = l / L - 1 (for a layer at depth by its own stretch, see HenckyLaw) and the lasting
/// stretch s, the energy is k L^2 s psi(e):
///   psi' = e (1 + beta e^2);  beyond yield psi' = e_y + H (e - e_y), which moves the rest length.
/// Each spring is critically damped by c = 2 sqrt(k m): m is the mean mass of its two vertices, k the sum of the
/// springs along the edge. Only integrations that ask for damping (Force::add_damping) use it. Equation 17 of the
/// source damps its springs too, but as printed it has not the dimension of a damping.
class MassSpring : public EdgeForce, public Layer {
public:
  MassSpring(const Triangles& triangles, const Vectors& reference, const std::vector<HenckyLaw>& laws,
             SpringMapping mapping);
  void commit(const Vectors& x) override;
  void add_damping(const Vectors& x, const std::vector<double>& mass, double rate, BlockMatrix& matrix) const override;
  std::vector<double> largest_stretch(const Vectors& x) const override;
  /// Springs that yield at x.
  int yielding(const Vectors& x) const;

protected:
  Tension tension(std::size_t k, double length) const override;

private:
  struct Spring {
    double stiffness, rest_length, along_edge; ///< N/mm, mm; N/mm, the sum of the springs along the same edge
    double plastic_stretch, layer_set;         ///< lasting stretch seen at the lumen, and the layer's own
    double stiffening, yield_strain, hardening, depth;
    double layer_strain(double length) const;
    double elastic_part(double strain) const { return yield_strain + hardening * (strain - yield_strain); }
  };
  std::vector<Spring> springs_;
  Triangles triangles_;
  std::vector<Mat2> inverse_edges_; ///< per triangle, in its reference plane
};

} // namespace vci
