// Cross-sections perpendicular to the axes.
#pragma once
#include "centreline/tree.hpp"
#include "measure/closed_stubs.hpp"

namespace anatomy {

struct Section {
  std::size_t branch = 0;                              ///< index in the tree
  std::size_t sample = 0;                              ///< index of the axis sample it is cut at
  double area = 0, min_diameter = 0, max_diameter = 0; ///< mm2, mm, mm
  std::string flag;                                    ///< ok, ostium, end
  double scatter = -1; ///< mm: noise of the mean radius by the outline's own roughness; negative if not known
  double equivalent_diameter() const { return std::sqrt(4 * area / M_PI); }
};

/// One section at every inner sample of every branch outside its parent's tube. It is the loop round the axis in which
/// the sample's plane cuts `surface`.
/// - Flag `ostium`: the loop runs over the wall of another branch or of a closed stub, and is clipped there at
///   ostium_clip inscribed radii.
/// - Flag `end`: within 1.5 R of a cap, in an extension, or the loop meets a cap.
/// @param splits pieces into which each measured edge is divided in `surface`; it helps to tell noise from shape
/// Throws ComputationError if no loop contains the axis away from the ends.
std::vector<Section> cut_sections(const Mesh& surface, const std::vector<Branch>& branches,
                                  const std::vector<End>& ends, int splits = 1,
                                  const std::vector<ClosedStub>& stubs = {});

/// Whether the axis at s is within 1.5 inscribed radii of a cap or in an extension.
bool near_an_end(const Branch& branch, const std::vector<End>& ends, double s);

constexpr double ostium_clip = 1.08;
constexpr double end_zone = 1.5; ///< inscribed radii

} // namespace anatomy
