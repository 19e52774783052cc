// The arrays of lumen.vtp: branch of each triangle, radii and plaque at each vertex (docs/design.md).
#pragma once
#include "measure/lesions.hpp"
#include <vtkPolyData.h>

namespace anatomy {

/// The arrays of a surface; docs/design.md says what each means.
struct LumenArrays {
  std::vector<int> branch_id;                                              ///< per face
  std::vector<double> radius_mm, reference_radius_mm, plaque_thickness_mm; ///< per vertex
  std::vector<int> plaque_type;                                            ///< per vertex
};

/// Makes the arrays for the remeshed surface `mesh`, which must have no removed elements. If the `input` surface has
/// the arrays plaque_thickness_mm and plaque_type, plaque is interpolated from its nearest triangle. Else the thickness
/// is the reference radius minus the distance to the axis, if positive, and the type is 1 where there is plaque. Where
/// a side branch runs inside the healthy lumen of its parent, the parent's reference radius and axis count if they give
/// more. At vertices inside caps plaque is 0.
LumenArrays lumen_arrays(const Mesh& mesh, const std::vector<Branch>& branches,
                         const std::vector<ReferenceProfile>& profiles, vtkPolyData* input);

} // namespace anatomy
