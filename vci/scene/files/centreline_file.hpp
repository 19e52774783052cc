// The centreline: its named branches, of a file or of points.
#pragma once
#include "vci/geometry/centreline.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace vci {

/// Each branch's name and points (mm). A side branch starts on its parent, the main branch at the inlet.
using NamedLines = std::vector<std::pair<std::string, Vectors>>;

/// The paths of branches. Throws common::InputError if a branch is missing, given twice or runs the wrong way.
/// @param where place of the branches, for messages
std::map<std::string, Path> centreline_from(NamedLines lines, const std::string& where);

/// Branch name -> path; a side branch's path starts at the inlet and has s = 0 where the branch leaves its parent.
std::map<std::string, Path> read_centreline(const std::filesystem::path& file);

} // namespace vci
