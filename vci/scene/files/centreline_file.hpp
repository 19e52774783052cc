// The centreline as named branches, read from a file or made from points.
#pragma once
#include "vci/geometry/centreline.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace vci {

/// Name and points (mm) of each branch. A side branch starts on its parent's axis, the main branch at the inlet.
using NamedLines = std::vector<std::pair<std::string, Vectors>>;

/// The paths of branches by their names, as read_centreline() returns them. Throws common::InputError if the main
/// branch is missing, or if a branch is given twice or runs the wrong way.
/// @param where name of the file or argument, for messages
std::map<std::string, Path> centreline_from(NamedLines lines, const std::string& where);

/// The paths of a file's branches by their names. A side branch's path starts at the inlet, and its arc length s is 0
/// where the branch leaves its parent.
std::map<std::string, Path> read_centreline(const std::filesystem::path& file);

} // namespace vci
