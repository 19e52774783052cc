// Springs along the triangles' edges, by Delingette or Van Gelder. They are not the springs of the published wall
// model, equations 13 to 16 of Lyu et al. 2025.
#pragma once
#include "vci/mechanics/fibre.hpp"
#include "vci/mechanics/hencky_law.hpp"
#include "vci/mechanics/layer.hpp"
#include "vci/wall/spring_mapping.hpp"

namespace vci {

/// Stiffness (N/mm) of a triangle's springs along the edges opposite to its corners 0, 1 and 2.
/// @param corners positions of the corners, mm
/// @param modulus_times_thickness N/mm
std::array<double, 3> spring_stiffness(const std::array<Vec3, 3>& corners, double modulus_times_thickness,
                                       double poisson_ratio, SpringMapping mapping);

/// A layer of the wall as springs. Each triangle has three springs of its own, so that each triangle can yield by
/// itself. An edge between two triangles therefore has two springs, whose forces add. A spring of stiffness k, length l
/// and rest length L has the strain e = l / L - 1; for a layer at depth, e is the layer's strain, not the
/// lumen's (see HenckyLaw). With the layer's permanent stretch s the energy is k L^2 s psi(e):
///   psi' = e (1 + beta e^2);  beyond the yield strain e_y  psi' = e_y + H (e - e_y), which moves the rest length.
/// Each spring's damping is critical, c = 2 sqrt(k m). Here m is the mean mass of its two vertices and k the sum of the
/// springs along the edge. Only the textbook scheme uses this damping (Force::add_damping). Equation 17 of
/// Lyu et al. 2025 damps springs too, but as printed it does not have the dimension of a damping.
class MassSpring : public EdgeForce, public Layer {
public:
  MassSpring(const Triangles& triangles, const Vectors& reference, const std::vector<HenckyLaw>& laws,
             SpringMapping mapping);
  void commit(const Vectors& x) override;
  void add_damping(const Vectors& x, const std::vector<double>& mass, double rate, BlockMatrix& matrix) const override;
  std::vector<double> largest_stretch(const Vectors& x) const override;
  /// Number of springs that yield at positions x.
  int count_yielding(const Vectors& x) const;

protected:
  Tension tension(std::size_t k, double length) const override;

private:
  struct Spring {
    /// k, N/mm; L, mm; sum of the stiffnesses of the springs along the same edge, N/mm
    double stiffness, rest_length, edge_stiffness;
    double plastic_stretch, layer_plastic_stretch; ///< permanent stretch of the lumen, and of the layer itself
    double stiffening, yield_strain, hardening, depth;
    double layer_strain(double length) const;
    double elastic_part(double strain) const { return yield_strain + hardening * (strain - yield_strain); }
  };
  std::vector<Spring> springs_;
  Triangles triangles_;
  std::vector<Mat2> inverse_edges_; ///< inverse of each triangle's edges_in_plane() at rest, 1/mm
};

} // namespace vci
