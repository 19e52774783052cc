#include "app/arrays.hpp"
#include <algorithm>
#include <cmath>
#include <vtkCell.h>
#include <vtkCellLocator.h>
#include <vtkDataArray.h>
#include <vtkGenericCell.h>
#include <vtkPointData.h>

namespace anatomy {
namespace {

// Interpolates plaque at each vertex from the nearest triangle of the input surface.
void interpolate_plaque(const Mesh& mesh, vtkPolyData* input, vtkDataArray* thickness, vtkDataArray* type,
                        LumenArrays& arrays) {
  vtkNew<vtkCellLocator> locator; // vtkStaticCellLocator may return a cell that is not the nearest (VTK 9.1)
  locator->SetDataSet(input);
  locator->BuildLocator();
  vtkNew<vtkGenericCell> cell;
  for (Vertex v : mesh.vertices()) {
    const Point& p = mesh.point(v);
    double x[3] = {p.x(), p.y(), p.z()}, nearest[3], pcoords[3], weights[3], d2;
    vtkIdType id;
    int sub;
    locator->FindClosestPoint(x, nearest, cell, id, sub, d2);
    cell->EvaluatePosition(nearest, nullptr, sub, pcoords, d2, weights);
    double t = 0, total = 0;
    int heaviest = 0;
    for (int k = 0; k < 3; ++k) {
      // On a sliver the weights of a point on its edge may be slightly outside [0, 1].
      const double weight = std::max(0.0, weights[k]);
      total += weight;
      t += weight * thickness->GetTuple1(cell->GetPointId(k));
      if (weights[k] > weights[heaviest])
        heaviest = k;
    }
    if (std::isnan(t))
      continue; // the input has no value here, so the estimate from the reference radius stays
    arrays.plaque_thickness_mm[v] = t / total;
    arrays.plaque_type[v] = static_cast<int>(type->GetTuple1(cell->GetPointId(heaviest)));
  }
}

// Thickness (mm) between the point p and the healthy wall of a branch, along the ray from its axis; not positive
// outside the healthy lumen.
double depth_in_healthy_lumen(const Vec3& p, const Branch& branch, const ReferenceProfile& profile) {
  const NearestAxis near = nearest_axis(branch, p);
  return 0.5 * profile.diameter(branch.s[near.sample]) - near.distance;
}

// Sets plaque to 0 at the inner vertices of caps, which are not wall.
void clear_plaque_on_caps(const Mesh& mesh, LumenArrays& arrays) {
  const RegionMap region = region_map(mesh);
  for (Vertex v : mesh.vertices()) {
    const auto faces = mesh.faces_around_target(mesh.halfedge(v));
    if (std::none_of(faces.begin(), faces.end(), [&](Face f) { return region[f] == 0; }))
      arrays.plaque_thickness_mm[v] = arrays.plaque_type[v] = 0;
  }
}

} // namespace

LumenArrays lumen_arrays(const Mesh& mesh, const std::vector<Branch>& branches,
                         const std::vector<ReferenceProfile>& profiles, vtkPolyData* input) {
  LumenArrays arrays;
  const std::size_t n = mesh.number_of_vertices();
  arrays.radius_mm.resize(n);
  arrays.reference_radius_mm.resize(n);
  arrays.plaque_thickness_mm.resize(n);
  arrays.plaque_type.resize(n);
  for (Vertex v : mesh.vertices()) {
    const NearestAxis near = nearest_axis(branches, vec(mesh.point(v)));
    const Branch& branch = branches[near.branch];
    arrays.radius_mm[v] = branch.radius[near.sample];
    arrays.reference_radius_mm[v] = 0.5 * profiles[near.branch].diameter(branch.s[near.sample]);
    double thickness = arrays.reference_radius_mm[v] - near.distance;
    // A side branch first runs through the plaque of its parent, which reaches to the parent's healthy wall. Where
    // branches leave close to each other, it may run through that of its parent's parent too.
    for (int parent = branch.parent; parent >= 0; parent = branches[parent].parent)
      thickness = std::max(thickness, depth_in_healthy_lumen(vec(mesh.point(v)), branches[parent], profiles[parent]));
    arrays.plaque_thickness_mm[v] = std::max(0.0, thickness);
    arrays.plaque_type[v] = arrays.plaque_thickness_mm[v] > 0 ? 1 : 0;
  }
  for (Face f : mesh.faces()) {
    Vec3 centre = Vec3::Zero();
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
      centre += vec(mesh.point(v)) / 3;
    arrays.branch_id.push_back(branches[nearest_axis(branches, centre).branch].id);
  }
  vtkDataArray* thickness = input->GetPointData()->GetArray("plaque_thickness_mm");
  vtkDataArray* type = input->GetPointData()->GetArray("plaque_type");
  if (thickness && type)
    interpolate_plaque(mesh, input, thickness, type, arrays);
  clear_plaque_on_caps(mesh, arrays);
  return arrays;
}

} // namespace anatomy
