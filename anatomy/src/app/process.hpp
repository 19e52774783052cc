// The steps of `lumen process`.
#pragma once
#include "app/prepare.hpp"

namespace anatomy {

/// Runs all steps and returns their results. `timer` takes the seconds of each step.
Anatomy process(const Options& options, StepTimer& timer);

} // namespace anatomy
