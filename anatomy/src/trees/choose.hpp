// Chooses the coronary tree in a model with an aorta, and cuts it off at its ostium.
#pragma once
#include "trees/aorta.hpp"

namespace anatomy {

/// The user's statements about the tree; empty if there are none.
struct TreeChoice {
  std::string name;           ///< left, right, tree1, ...; whole: nothing is cut off
  std::optional<Vec3> ostium; ///< mm; the tree is cut across there
  std::vector<Vec3> outlets;  ///< mm; the chosen tree is near all of them

  bool is_given() const { return !name.empty() || ostium; }
};

/// The aorta of a closed mesh with its openings tagged: an evident one or, if the user chooses a tree, any trunk wider
/// than 9 mm. Warns of a wide vessel with two such ends that is not evidently an aorta. units: the declared ones.
/// Throws InputError if the mesh is an aorta with coronaries ten times too small for these units, or if the user
/// chooses a tree and there is none.
std::optional<Aorta> aorta_of(const Mesh& mesh, const TreeChoice& choice, const std::string& units,
                              std::vector<Repair>& repairs);

/// The chosen tree: the only one, or the one by ostium, name or outlets. Throws InputError with the list of trees if
/// several or none fit.
const CoronaryTree& chosen(const Aorta& aorta, const TreeChoice& choice);

/// The plane of the cut: at the user's ostium if it lies on the tree, else at the found ostium. Throws InputError if
/// none was found.
Plane cut_of(const Mesh& mesh, const CoronaryTree& tree, const TreeChoice& choice);

/// Keeps only the tree. The opening at its ostium is left for cap_open_ends, and the mesh has no garbage. Throws
/// InputError if the plane does not separate the tree.
void cut_off(Mesh& mesh, const CoronaryTree& tree, const Plane& plane, std::vector<Repair>& repairs);

/// One line a tree: name, ostium, diameter there, length.
std::string line_of(const CoronaryTree& tree);

} // namespace anatomy
