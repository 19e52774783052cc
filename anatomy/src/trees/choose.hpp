// Which coronary tree of a model with an aorta is meant, and the cut at its ostium.
#pragma once
#include "trees/aorta.hpp"

namespace anatomy {

/// What the user says of the tree; empty where he says nothing.
struct TreeChoice {
  std::string name;           ///< left, right, tree1, ...; whole: the model is taken as it is
  std::optional<Vec3> ostium; ///< mm; the tree is cut across there
  std::vector<Vec3> outlets;  ///< mm; a tree near all of them is the one

  bool is_given() const { return !name.empty() || ostium; }
};

/// The aorta of a closed mesh with its openings tagged: an evident one, or on the user's word any trunk wider than 9
/// mm. A wide vessel with two such ends that is not evidently one is warned of. units: the declared ones, which are
/// refused where the mesh is an aorta with its coronaries ten times too small. Throws InputError where the user chooses
/// a tree and there is none.
std::optional<Aorta> aorta_of(const Mesh& mesh, const TreeChoice& choice, const std::string& units,
                              std::vector<Repair>& repairs);

/// The tree that is meant: the only one, or by the ostium, the name or the outlets. Throws InputError with the list
/// where that leaves several or none.
const CoronaryTree& chosen(const Aorta& aorta, const TreeChoice& choice);

/// Where it is cut: at the user's ostium where that lies on the tree, else at the one found. Throws InputError where
/// none was found.
Plane cut_of(const Mesh& mesh, const CoronaryTree& tree, const TreeChoice& choice);

/// Keeps the tree alone; the opening at its ostium is left for cap_open_ends, and the mesh holds no garbage. Throws
/// InputError where the plane does not separate the tree.
void cut_off(Mesh& mesh, const CoronaryTree& tree, const Plane& plane, std::vector<Repair>& repairs);

/// One line a tree: name, ostium, diameter there, length.
std::string line_of(const CoronaryTree& tree);

} // namespace anatomy
