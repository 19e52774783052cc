// File input and output of the deployment engine: reads scene, lumen and centreline, writes lumen and shapes. Link
// vci::files.
#pragma once
#include "vci/scene/files/centreline_file.hpp"
#include "vci/scene/files/lumen_file.hpp"
#include "vci/scene/files/scene_file.hpp"
#include "vci/vci.hpp"
