// Makes a closed, repaired lumen with its ends from a file: the first steps of all commands of `lumen`.
#pragma once
#include "app/output.hpp"
#include "ends/find_ends.hpp"
#include "files/cap_files.hpp"
#include "measure/coarse_mask.hpp"
#include "trees/choose.hpp"
#include <optional>
#include <vector>
#include <vtkPolyData.h>

namespace anatomy {

struct Options {
  std::string input, units = "mm";
  std::vector<int> labels; ///< of a mask; none: its only label
  double edge = 0.4;       ///< mm
  double spacing = 0.25;   ///< mm between sections
  std::optional<Vec3> inlet;
  std::vector<Vec3> outlets;     ///< in the order of their names, or empty
  std::vector<Vec3> cuts;        ///< points where the vessel is cut across
  std::vector<std::string> caps; ///< files: the inlet's, then the outlets' in the order of their names; or empty
  bool close_others = false;     ///< openings without a point or cap are closed
  std::string tree;              ///< of a model with an aorta; or empty
  std::optional<Vec3> ostium;    ///< of that tree
  double extend_inlet = 0, extend_outlets = 0; ///< radii of straight extension
  std::string like;                            ///< anatomy.json of an earlier state, or empty
};

/// The repaired surface, closed, outward, its openings tagged.
struct Closed {
  vtkSmartPointer<vtkPolyData> input;
  Mesh mesh;
  NamedEnds named;
  std::optional<Aorta> aorta;
  std::vector<Repair> repairs;
};

/// A lumen with tagged flat caps, and its ends by falling area.
struct Prepared {
  vtkSmartPointer<vtkPolyData> input;
  Mesh mesh;      ///< refined where it is coarse
  Mesh given;     ///< before refining
  int splits = 1; ///< of an edge of `given` in `mesh`
  Voxels voxels;  ///< on which the lumen was segmented
  NamedEnds named;
  std::vector<End> ends;
  std::vector<Candidate> candidates; ///< for ends, with the decisions
  std::vector<Repair> repairs;
};

/// Throws InputError if the file or the options cannot be used.
Closed closed_surface(const Options& options, StepTimer& timer);

/// The lumen with its ends. In a model with an aorta the tree is cut off first.
Prepared with_ends(Closed closed, const CoronaryTree* tree, const Options& options, StepTimer& timer);

/// Both steps, for the tree that the options choose.
Prepared prepare(const Options& options, StepTimer& timer);

TreeChoice choice_of(const Options& options);

/// Prints to standard error the warnings among the repairs with index `from` and higher.
void say_warnings(const std::vector<Repair>& repairs, std::size_t from);

} // namespace anatomy
