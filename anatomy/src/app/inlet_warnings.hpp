// Warns where the chosen inlet, or the course of the vessels from it, may be wrong.
#pragma once
#include "centreline/tree.hpp"

namespace anatomy {

/// A reason to doubt that the largest end is the inlet, as text: another end is about as wide. Empty if none is.
std::string wide_end_doubt(const std::vector<End>& ends);

/// Adds a warning to `notes` if the inlet may be another end than the largest one, which was chosen. If the ostium is
/// narrowed, the largest end is not the inlet. There are four reasons for a warning:
/// - another end is about as wide as the inlet;
/// - main's last third is about as wide as the inlet, and then narrows to main's end;
/// - main widens from the inlet;
/// - the side branches lean back towards the inlet on average.
void warn_of_doubtful_inlet(const std::vector<End>& ends, const std::vector<Branch>& branches,
                            std::vector<Repair>& notes);

/// Warns if an outlet is at least a quarter wider than the inlet that the user named.
void warn_of_narrow_inlet(const std::vector<End>& ends, std::vector<Repair>& notes);

/// Warns of each branch whose axis turns back where a side branch leaves. The longest path through a graft does so.
void warn_of_turning_back(const std::vector<Branch>& branches, std::vector<Repair>& notes);

} // namespace anatomy
