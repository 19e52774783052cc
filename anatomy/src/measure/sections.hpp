// Cross-sections perpendicular to the axes.
#pragma once
#include "centreline/tree.hpp"
#include "measure/closed_stubs.hpp"

namespace anatomy {

/// Whether a section shows the vessel alone; see cut_sections().
enum class SectionFlag {
  ok,     ///< all of its outline is the branch's wall
  ostium, ///< its outline is closed across the mouth of another branch or of a stub
  end     ///< it is too near to a cap, or meets one
};

struct Section {
  std::size_t branch = 0;                              ///< index of its branch
  std::size_t sample = 0;                              ///< index of the axis sample it is cut at
  double area = 0, min_diameter = 0, max_diameter = 0; ///< mm2, mm, mm
  SectionFlag flag = SectionFlag::ok;
  double scatter = -1; ///< mm: standard deviation of the mean radius by the outline's roughness; negative if not known
  double equivalent_diameter() const { return std::sqrt(4 * area / pi); }
};

/// One section at every axis sample of every branch, except the branch's first and last sample and those in its
/// parent's inscribed tube. A section is the loop round the axis in which the plane across the axis cuts `surface`.
/// - Flag `ostium`: the loop runs over the wall of another branch or of a closed stub. The section is closed across
///   that mouth by the ellipse that fits the rest of the loop.
/// - Flag `end`: the section is within 1.5 inscribed radii of a cap or in an extension, or its loop meets a cap.
/// Throws ComputationError if no loop contains the axis away from the ends.
/// @param splits number of pieces into which refinement has divided each edge of the measured wall; noise has the scale
/// of the undivided edges
std::vector<Section> cut_sections(const Mesh& surface, const std::vector<Branch>& branches,
                                  const std::vector<End>& ends, int splits = 1,
                                  const std::vector<ClosedStub>& stubs = {});

/// Whether the axis at arc length s (mm) is within 1.5 inscribed radii of a cap or in an extension.
bool is_near_end(const Branch& branch, const std::vector<End>& ends, double s);

/// A point of a section on another branch's wall lies in a mouth if it is more inscribed radii than this from the axis.
constexpr double mouth_distance = 1.08;
constexpr double end_zone = 1.5; ///< a section within so many inscribed radii of a cap is flagged `end`

} // namespace anatomy
