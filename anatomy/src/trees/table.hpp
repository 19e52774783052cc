// The coronary trees of a model with an aorta, for the user to see.
#pragma once
#include "trees/aorta.hpp"
#include <nlohmann/json.hpp>

namespace anatomy {

struct TreeEntry {
  CoronaryTree tree;
  std::size_t outlets = 0; ///< number of its outlets
};

/// A table to print, with the aorta's width and how to choose a tree; empty without an aorta.
std::string table_of(const std::vector<TreeEntry>& trees, const std::optional<Aorta>& aorta);

/// The trees as a list for `anatomy ends` to draw: name, ostium_mm, diameter_mm, length_mm, outlets.
nlohmann::ordered_json document_of(const std::vector<TreeEntry>& trees);

} // namespace anatomy
