// A lumen that moves with a coarser mesh of itself. The coarse mesh is deployed, which takes less time.
#pragma once
#include "vci/geometry/carried_points.hpp"
#include "vci/geometry/lumen.hpp"
#include "vci/procedure/deployment.hpp"

#include <string>

namespace vci {

class CarriedLumen {
public:
  /// Throws common::InputError if a point of `fine` is further from `coarse` than its radius: another part of the wall
  /// might then be nearer.
  /// @param coarse the lumen that is deployed
  /// @param name of the coarse lumen, for the message
  CarriedLumen(const Lumen& coarse, const Lumen& fine, const std::string& name);

  /// Points (mm) of the fine lumen once those of the coarse lumen are at `deployed`.
  Vectors points(const Vectors& deployed) const { return carried_.displaced_points(deployed); }
  /// The result with points, stretch and gaps at the fine lumen's points. The forces remain those of the coarse lumen.
  DeploymentResult carried(DeploymentResult result) const;

private:
  CarriedPoints carried_;
};

} // namespace vci
