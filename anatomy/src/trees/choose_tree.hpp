// Chooses the coronary tree in a model with an aorta, and cuts it off at its ostium.
#pragma once
#include "files/length_unit.hpp"
#include "trees/aorta.hpp"

namespace anatomy {

/// The user's statements about the tree; empty if there are none.
struct TreeChoice {
  std::string name;           ///< left, right, tree1, ...
  std::optional<Vec3> ostium; ///< mm; a point on the tree, which is cut across there
  std::vector<Vec3> outlets;  ///< mm; points near the outlets, all of which are on the chosen tree
  bool whole = false;         ///< the model is taken as it is: nothing is cut off

  bool is_given() const { return !name.empty() || ostium; }
};

/// The aorta of a closed mesh with its openings tagged; nothing if it has none. It is an evident aorta (is_evident())
/// or, if the user chooses a tree, any trunk wider than 9 mm with a tree. Warns of a trunk with two ends and a tree
/// that is not evidently an aorta. Throws InputError if the mesh is an aorta with coronary arteries ten times too
/// small, if the user chooses a tree and there is none, or if a vessel on the aorta cannot be followed.
/// @param unit length unit that the user declared
std::optional<Aorta> find_aorta_to_cut(const Mesh& mesh, const TreeChoice& choice, LengthUnit unit,
                                       std::vector<Repair>& repairs);

/// The tree that the user's ostium, name or outlets choose, or the only tree. Throws InputError with the list of trees
/// if several or none fit.
const CoronaryTree& choose_tree(const Aorta& aorta, const TreeChoice& choice);

/// The plane of the cut: at the user's ostium if a plane across the tree is found there, else at the ostium that
/// find_aorta() found. Throws InputError if there is neither.
Plane tree_cut_plane(const Mesh& mesh, const CoronaryTree& tree, const TreeChoice& choice);

/// Cuts the mesh at `plane` and keeps the tree alone. The opening at its ostium stays open, for cap_open_ends to close.
/// The mesh has no garbage on return. Throws InputError if the plane does not separate the tree.
void cut_tree_off_aorta(Mesh& mesh, const CoronaryTree& tree, const Plane& plane, std::vector<Repair>& repairs);

/// A line of text on a tree: name, ostium, diameter at the ostium, length.
std::string tree_line(const CoronaryTree& tree);

} // namespace anatomy
