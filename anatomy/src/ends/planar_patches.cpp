#include "ends/planar_patches.hpp"
#include "core/faces.hpp"
#include <algorithm>
#include <numeric>

namespace anatomy {
namespace {

// Cosine of the largest angle, 60 degrees, between the normals of a face and of the plane. Noise of a third of the
// edges' length turns faces as far.
constexpr double cos_faces = 0.5;
constexpr int most_fits = 4; // largest number of times that a plane is fitted to the patch and the patch grown again

// The connected faces round `seed` that lie within `off_plane` mm of the plane. Faces flagged in `taken` are left out.
// The faces visited get the number `mark` in `seen`.
std::vector<Face> grow_patch(const Mesh& mesh, Face seed, const PatchPlane& plane, double off_plane,
                             const std::vector<bool>& taken, std::vector<int>& seen, int mark) {
  const auto belongs = [&](Face f) {
    for (Vertex v : mesh.vertices_around_face(mesh.halfedge(f)))
      if (std::abs((vec(mesh.point(v)) - plane.centre).dot(plane.normal)) > off_plane)
        return false;
    const Vec3 area = area_vector(mesh, f);
    return area.dot(plane.normal) >= cos_faces * area.norm();
  };
  std::vector<Face> patch{seed};
  seen[seed] = mark;
  for (std::size_t i = 0; i < patch.size(); ++i)
    for (Face g : mesh.faces_around_face(mesh.halfedge(patch[i])))
      if (!taken[g] && seen[g] != mark && belongs(g)) {
        seen[g] = mark;
        patch.push_back(g);
      }
  return patch;
}

} // namespace

PatchPlane plane_of(const Mesh& mesh, const std::vector<Face>& faces) {
  PatchPlane plane;
  Vec3 total = Vec3::Zero();
  double weight = 0;
  for (Face f : faces) {
    const Vec3 area = area_vector(mesh, f);
    total += area;
    weight += area.norm();
    plane.centre += area.norm() * centroid(mesh, f);
  }
  plane.centre /= weight;
  plane.area = total.norm();
  plane.normal = total / plane.area;
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  std::vector<Vec2> corners_in_plane;
  for (Face f : faces) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Matrix2d corners = Eigen::Matrix2d::Zero();
    for (Vertex w : mesh.vertices_around_face(mesh.halfedge(f))) {
      const Vec3 d = vec(mesh.point(w)) - plane.centre;
      const Eigen::Vector2d p(d.dot(u), d.dot(v));
      corners_in_plane.push_back(p);
      sum += p;
      corners += p * p.transpose();
      plane.lowest = std::min(plane.lowest, d.dot(plane.normal));
      plane.highest = std::max(plane.highest, d.dot(plane.normal));
    }
    // A triangle's exact second moments.
    moments += area_vector(mesh, f).norm() / 12 * (sum * sum.transpose() + corners);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moments / weight);
  plane.extent = least_extent(corners_in_plane);
  plane.width = 4 * std::sqrt(std::max(axes.eigenvalues()[0], 0.0));
  return plane;
}

std::map<int, std::vector<Face>> tagged_faces(const Mesh& mesh) {
  std::map<int, std::vector<Face>> faces;
  const RegionMap region = region_map(mesh);
  for (Face f : mesh.faces())
    if (region[f] != 0)
      faces[region[f]].push_back(f);
  return faces;
}

std::vector<std::vector<Face>> planar_patches(const Mesh& mesh, double off_plane, double least_area) {
  const RegionMap region = region_map(mesh);
  std::vector<bool> taken(mesh.number_of_faces());
  std::vector<double> area(mesh.number_of_faces());
  for (Face f : mesh.faces()) {
    taken[f] = region[f] != 0;
    area[f] = area_vector(mesh, f).norm();
  }
  std::vector<std::size_t> seeds(mesh.number_of_faces());
  std::iota(seeds.begin(), seeds.end(), 0);
  std::stable_sort(seeds.begin(), seeds.end(), [&](std::size_t a, std::size_t b) { return area[a] > area[b]; });
  std::vector<int> seen(mesh.number_of_faces(), 0);
  std::vector<std::vector<Face>> patches;
  int mark = 0;
  for (std::size_t s : seeds) {
    const Face seed(static_cast<Mesh::size_type>(s));
    if (taken[seed] || area[s] == 0)
      continue;
    std::vector<Face> patch{seed};
    for (int fit = 0; fit < most_fits; ++fit) {
      const std::size_t before = patch.size();
      patch = grow_patch(mesh, seed, plane_of(mesh, patch), off_plane, taken, seen, ++mark);
      if (patch.size() <= before)
        break;
    }
    for (Face f : patch)
      taken[f] = true;
    if (plane_of(mesh, patch).area >= least_area)
      patches.push_back(patch);
  }
  return patches;
}

} // namespace anatomy
