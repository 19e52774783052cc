// Cross-sections perpendicular to the axes.
#pragma once
#include "centreline/tree.hpp"

namespace anatomy {

struct Section {
  std::size_t branch = 0; ///< index in the tree
  std::size_t sample = 0; ///< index of the axis sample it is cut at
  double area = 0, min_diameter = 0, max_diameter = 0;
  std::string flag;    ///< ok, ostium, end
  double scatter = -1; ///< mm: of the mean radius, by the outline's own roughness; negative where that cannot be told
  double equivalent_diameter() const { return std::sqrt(4 * area / M_PI); }
};

/// One section at every inner sample of every branch outside its parent's tube, as the loop of the plane's cut through
/// `surface` that contains the axis. Where the loop runs over another branch's wall it is clipped there at
/// ostium_clip times the inscribed radius (flag ostium); within 1.5 R of a cap, in an extension, or if the loop meets a
/// cap, the flag is end. `splits`: into how many each edge as measured has been divided in `surface`, which tells noise
/// from shape. Throws ComputationError where no loop contains the axis away from the ends.
std::vector<Section> cut_sections(const Mesh& surface, const std::vector<Branch>& branches,
                                  const std::vector<End>& ends, int splits = 1);

/// Whether the axis at s is within 1.5 inscribed radii of a cap or in an extension.
bool near_an_end(const Branch& branch, const std::vector<End>& ends, double s);

constexpr double ostium_clip = 1.08;
constexpr double end_zone = 1.5; ///< inscribed radii

} // namespace anatomy
