// The deployment engine as a library with file readers and writers. They read scenes, lumens and centrelines, and write
// lumens and device shapes. Programs that include this header link vci::files.
#pragma once
#include "vci/scene/files/centreline_file.hpp"
#include "vci/scene/files/lumen_file.hpp"
#include "vci/scene/files/scene_file.hpp"
#include "vci/vci.hpp"
