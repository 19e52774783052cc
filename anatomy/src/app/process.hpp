// The steps of `lumen process`, and the shorter ones of `check` and `remesh`.
#pragma once
#include "app/output.hpp"
#include "ends/find_ends.hpp"
#include <optional>

namespace anatomy {

struct Options {
  std::string input, units = "mm";
  int label = 0;         ///< of a mask; 0: its only one
  double edge = 0.4;     ///< mm
  double spacing = 0.25; ///< mm between sections
  std::optional<Vec3> inlet;
  std::vector<Vec3> outlets;     ///< in the order of their names, or empty
  std::vector<Vec3> cuts;        ///< points where the vessel is cut across
  std::vector<std::string> caps; ///< files: the inlet's, then the outlets' in the order of their names; or empty
  bool close_others = false;     ///< openings without a point or cap are closed
  double extend_inlet = 0, extend_outlets = 0; ///< radii of straight extension
  std::string like;                            ///< anatomy.json of an earlier state, or empty
};

/// The repaired, closed, outward surface with tagged flat caps, and its ends by falling area.
struct Prepared {
  vtkSmartPointer<vtkPolyData> input;
  Mesh mesh;      ///< refined where it is coarse
  Mesh given;     ///< before refining
  int splits = 1; ///< of an edge of `given` in `mesh`
  std::vector<End> ends;
  std::vector<Candidate> candidates; ///< for ends, and what was decided
  std::vector<Repair> repairs;
};

Prepared prepare(const Options& options, StepTimer& timer);
Anatomy process(const Options& options, StepTimer& timer);

} // namespace anatomy
