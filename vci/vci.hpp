// The deployment engine as a library: all that a program needs to run a procedure on arrays of its own.
// Link vci::vci. vci/files.hpp reads and writes files besides; link vci::files for it.
#pragma once
#include "common/error.hpp"
#include "vci/bench/bench.hpp"
#include "vci/bench/crush.hpp"
#include "vci/geometry/arrays.hpp"
#include "vci/geometry/sections.hpp"
#include "vci/procedure/deployment.hpp"
#include "vci/procedure/radius_correction.hpp"
#include "vci/scene/checks/lumen_check.hpp"
#include "vci/scene/checks/plausibility.hpp"
