// The arrays of lumen.vtp: branch of each triangle, radii and plaque of each vertex.
#pragma once
#include "measure/lesions.hpp"
#include <vtkPolyData.h>

namespace anatomy {

struct Arrays {
  std::vector<int> branch_id;                                              ///< per face
  std::vector<double> radius_mm, reference_radius_mm, plaque_thickness_mm; ///< per vertex
  std::vector<int> plaque_type;                                            ///< per vertex
};

/// mesh must have no removed elements. If the input has the arrays plaque_thickness_mm and plaque_type, plaque is
/// interpolated from its nearest triangle. Else it is the reference radius minus the distance to the axis, if positive.
Arrays arrays_of(const Mesh& mesh, const std::vector<Branch>& branches, const std::vector<ReferenceProfile>& profiles,
                 vtkPolyData* input);

} // namespace anatomy
