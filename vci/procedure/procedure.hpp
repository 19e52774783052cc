// A procedure as data: each step becomes three stages that the same solver relaxes one after the other.
#pragma once
#include "vci/scene/scene.hpp"

namespace vci {

/// The settings of a stage, and whether its end ties the stents to the wall.
struct Stage {
  std::string name;
  double pressure_fraction; ///< of the step's pressure
  bool with_balloons;       ///< false: balloons are taken out
  bool ties_stents;         ///< at its end the stents are tied to the wall where they touch it
};

std::vector<Stage> stages_of(const Step& step, const Numerics& numerics);

} // namespace vci
