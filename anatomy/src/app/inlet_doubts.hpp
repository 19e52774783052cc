// What speaks against an inlet that was chosen by its size alone.
#pragma once
#include "centreline/tree.hpp"

namespace anatomy {

/// `notes` takes a warning in four cases: another end is about as wide as the inlet; the vessel is, before it narrows
/// to its other end; the main branch widens from the inlet; the side branches lean back towards it on average. The
/// inlet is the largest end, which is wrong where the ostium is narrowed.
void doubt_inlet(const std::vector<End>& ends, const std::vector<Branch>& branches, std::vector<Repair>& notes);

} // namespace anatomy
