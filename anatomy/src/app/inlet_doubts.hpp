// What speaks against the inlet, and against the course of the vessels from it.
#pragma once
#include "centreline/tree.hpp"

namespace anatomy {

/// `notes` takes a warning in four cases: another end is about as wide as the inlet; the vessel is, before it narrows
/// to its other end; the main branch widens from the inlet; the side branches lean back towards it on average. The
/// inlet is the largest end, which is wrong where the ostium is narrowed.
void doubt_inlet(const std::vector<End>& ends, const std::vector<Branch>& branches, std::vector<Repair>& notes);

/// Warns if an outlet is a quarter wider than the inlet that the user named.
void doubt_named_inlet(const std::vector<End>& ends, std::vector<Repair>& notes);

/// Warns of each branch whose axis turns back where another one leaves, as the longest way through a graft does.
void doubt_course(const std::vector<Branch>& branches, std::vector<Repair>& notes);

} // namespace anatomy
