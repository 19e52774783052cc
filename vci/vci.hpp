// The deployment engine as a library, for programs that run a procedure on their own arrays. Link vci::vci.
// vci/files.hpp also reads and writes files; link vci::files for it.
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
