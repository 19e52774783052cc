// Files of the deployment engine: scene, lumen and centreline read, lumen and shapes written. Link vci::files.
#pragma once
#include "vci/scene/files/centreline_file.hpp"
#include "vci/scene/files/lumen_file.hpp"
#include "vci/scene/files/scene_file.hpp"
#include "vci/vci.hpp"
