// Deployment on a mesh of the lumen with longer edges, which carries the points of the fine lumen along.
#pragma once
#include "vci/geometry/carried_points.hpp"
#include "vci/procedure/deployment.hpp"
#include "vci/scene/files/lumen_file.hpp"

#include <optional>

namespace vci {

class CoarseLumen {
public:
  /// Reads the lumen that the scene names as `coarse_lumen`. Throws common::InputError if the file is bad, or if a
  /// point of `fine` is further from this lumen than its `radius_mm`: another part of the wall might then be nearer.
  CoarseLumen(const Scene& scene, const Lumen& fine);

  /// The scene with the coarse lumen's file as its lumen, for checks and their messages.
  const Scene& scene() const { return scene_; }
  const LumenFile& lumen() const { return lumen_; }
  /// The result with points, stretch and gaps at the fine lumen's points. The forces remain those of the coarse lumen.
  DeploymentResult carry_to_fine(DeploymentResult result) const;

private:
  Scene scene_;
  LumenFile lumen_;
  CarriedPoints carried_;
};

/// The coarse lumen of a scene; nothing if the scene names none.
std::optional<CoarseLumen> load_coarse_lumen(const Scene& scene, const Lumen& fine);

} // namespace vci
