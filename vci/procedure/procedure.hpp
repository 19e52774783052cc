// The stages of a procedure's steps. For each step the solver relaxes three stages, one after the other.
#pragma once
#include "vci/scene/scene.hpp"

namespace vci {

/// What is set before a stage is relaxed and what is done at its end.
struct Stage {
  std::string name;
  double pressure_fraction; ///< pressure in the balloons over the step's pressure
  bool with_balloons;       ///< false: the balloons are taken out first
  bool ties_stents;         ///< at the stage's end stents are tied to the wall where they touch it
};

/// The three stages of a step: inflation with a part of the pressure, with all of it, and extraction of the balloons.
std::vector<Stage> stages_of(const Step& step, const Numerics& numerics);

} // namespace vci
