// Makes a closed, repaired lumen with known ends from a file. These are the first steps of all commands of `lumen`.
#pragma once
#include "app/output.hpp"
#include "ends/find_ends.hpp"
#include "files/cap_files.hpp"
#include "measure/coarse_mask.hpp"
#include "trees/choose_tree.hpp"
#include <optional>
#include <vector>
#include <vtkPolyData.h>

namespace anatomy {

/// The options of the command line.
struct Options {
  std::string input;
  LengthUnit unit = LengthUnit::mm;
  std::vector<int> labels;       ///< labels of a mask, taken together; empty for its only label
  double edge = 0.4;             ///< mm, edge length of the new surface
  double spacing = 0.25;         ///< mm between cross-sections
  std::optional<Vec3> inlet;     ///< mm, a point near the inlet
  std::vector<Vec3> outlets;     ///< mm, points near the outlets in the order of their names, or empty
  std::vector<Vec3> cuts;        ///< mm, points near which the vessel is cut across
  std::vector<std::string> caps; ///< cap files: the inlet's, then the outlets' in the order of their names; or empty
  bool close_others = false;     ///< whether openings without a point or a cap file are closed
  std::string tree;              ///< name of the coronary tree in a model with an aorta, or empty
  std::optional<Vec3> ostium;    ///< mm, where that tree leaves the aorta
  bool whole = false;            ///< whether such a model is taken as it is, with its aorta
  double extend_inlet = 0, extend_outlets = 0; ///< length of the straight extension, in radii of the end
  std::string like;                            ///< path of the anatomy.json of an earlier state, or empty
};

/// The repaired surface before its ends are sought: closed, with normals outward and tagged caps on its openings.
struct ClosedSurface {
  vtkSmartPointer<vtkPolyData> input;
  Mesh mesh;
  NamedEnds named;
  std::optional<Aorta> aorta; ///< if the surface has one
  std::vector<Repair> repairs;
};

/// A lumen with tagged flat caps, and its ends by decreasing area.
struct PreparedLumen {
  vtkSmartPointer<vtkPolyData> input;
  Mesh mesh;      ///< the lumen, refined if it is coarse
  Mesh unrefined; ///< the lumen before refining
  int splits = 1; ///< number of parts into which refining divides an edge of `unrefined`
  Voxels voxels;  ///< the voxels on which the lumen was segmented
  NamedEnds named;
  std::vector<End> ends;
  std::vector<EndCandidate> candidates; ///< places where the vessel may end, with the decisions
  std::vector<Repair> repairs;
};

/// Reads, repairs and closes the surface. Throws InputError if the file or the options cannot be used.
ClosedSurface closed_surface(const Options& options, StepTimer& timer);

/// Finds the ends of the lumen. If a `tree` is given, it is cut off from its aorta first.
PreparedLumen find_lumen_ends(ClosedSurface closed, const CoronaryTree* tree, const Options& options, StepTimer& timer);

/// Runs closed_surface() and find_lumen_ends() for the tree that the options choose, and prints the warnings.
PreparedLumen prepare(const Options& options, StepTimer& timer);

TreeChoice tree_choice_of(const Options& options);

/// Prints to standard error the warnings among the repairs from index `from` on.
void print_warnings(const std::vector<Repair>& repairs, std::size_t from);

} // namespace anatomy
