// The file of the centreline: its named branches.
#pragma once
#include "vci/geometry/centreline.hpp"

#include <filesystem>
#include <map>
#include <string>

namespace vci {

/// Branch name -> path; a side branch's path starts at the inlet and has s = 0 where the branch leaves its parent.
std::map<std::string, Path> read_centreline(const std::filesystem::path& file);

} // namespace vci
