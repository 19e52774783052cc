// The steps of `lumen process`.
#pragma once
#include "app/prepare.hpp"

namespace anatomy {

Anatomy process(const Options& options, StepTimer& timer);

} // namespace anatomy
