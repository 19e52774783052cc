// The deployment engine as a library, for programs that have lumen and centreline as arrays. Such programs link
// vci::vci. Programs that also read or write files include vci/files.hpp and link vci::files.
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
