// The wall's material and the model of its layers.
#pragma once
#include "vci/wall/spring_mapping.hpp"

#include <array>
#include <limits>

namespace vci {

/// The model of a layer: constant-strain triangles, or springs along their edges.
enum class WallModel { membrane, mass_spring };

struct PlaqueSpec {
  double youngs_modulus; ///< MPa
  double yield_strain;   ///< infinity: the plaque does not yield
  double hardening;      ///< stiffness beyond yield over the stiffness before, 0 to 1
};

struct WallSpec {
  WallModel model = WallModel::membrane;
  SpringMapping spring_mapping = SpringMapping::lame;
  double youngs_modulus = 0.8; ///< MPa
  double poisson_ratio = 0.45;
  double thickness = 0.6;             ///< intima and media together, mm
  double stiffening = 3;              ///< beta of the HenckyLaw
  double tissue_modulus = 0.08;       ///< modulus of the tissue round the vessel, MPa
  double tangential_stiffness = 0.02; ///< MPa/mm, against sliding in that tissue
  double density = 0.0011;            ///< g/mm^3
  double hinge_yield = 0.1;           ///< rad: an edge between triangles that bends by more keeps a fold
  /// By plaque_type: 0 unused, 1 fibrous, 2 lipid, 3 calcified.
  std::array<PlaqueSpec, 4> plaque{
      {{1, std::numeric_limits<double>::infinity(), 0}, {2.0, 0.12, 0.08}, {0.5, 0.10, 0.05}, {20.0, 0.065, 0.05}}};
};

} // namespace vci
