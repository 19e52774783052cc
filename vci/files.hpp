// The deployment engine as a library, with its readers and writers of files: reads scene, lumen and centreline, writes
// lumen and shapes. Programs that include this header link vci::files.
#pragma once
#include "vci/scene/files/centreline_file.hpp"
#include "vci/scene/files/lumen_file.hpp"
#include "vci/scene/files/scene_file.hpp"
#include "vci/vci.hpp"
