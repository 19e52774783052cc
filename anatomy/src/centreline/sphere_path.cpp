#include "centreline/sphere_path.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// The direction at a place follows from the wall round it. Only wall less than this before or behind the place counts
// (in radii, along the path).
constexpr double wall_band_radii = 0.6;
// Only wall within this many radii of the place counts. This includes the wall of an oval vessel, but not of a
// neighbour.
constexpr double wall_reach_radii = 2;
// Cosine of the largest angle, 30 degrees, between the two directions in vessel_direction.
constexpr double least_agreement_cosine = 0.87;

} // namespace

SpherePath::SpherePath(const InscribedSpheres& all, const ShortestPaths& cheapest, std::size_t sphere) {
  for (std::size_t at = sphere, last = all.centre.size(); at != last; at = cheapest.previous[at]) {
    last = at;
    s.push_back(points.empty() ? 0 : s.back() + (all.centre[at] - points.back()).norm());
    spheres.push_back(at);
    points.push_back(all.centre[at]);
    radius.push_back(all.radius[at]);
  }
}

std::size_t SpherePath::index_at(double where) const {
  const auto above = std::lower_bound(s.begin(), s.end(), where);
  return std::min(static_cast<std::size_t>(above - s.begin()), s.size() - 1);
}

Vec3 SpherePath::centre(double where) const {
  const double width = 0.25 * radius[index_at(where)];
  Vec3 sum = Vec3::Zero();
  int n = 0;
  for (std::size_t i = 0; i < s.size(); ++i)
    if (std::abs(s[i] - where) <= width) {
      sum += points[i];
      ++n;
    }
  return n > 0 ? Vec3(sum / n) : points[index_at(where)];
}

Vec3 vessel_direction(const Mesh& mesh, const SpherePath& path, double where) {
  const double r = path.radius[path.index_at(where)];
  const Vec3 centre = path.centre(where);
  const Vec3 along =
      (path.centre(std::min(where + r, path.length())) - path.centre(std::max(where - 0.5 * r, 0.0))).normalized();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (Face f : mesh.faces()) {
    const Halfedge h = mesh.halfedge(f);
    const Vec3 a = vec(mesh.point(mesh.source(h))), b = vec(mesh.point(mesh.target(h))),
               c = vec(mesh.point(mesh.target(mesh.next(h))));
    const Vec3 p = (a + b + c) / 3 - centre, area = (b - a).cross(Vec3(c - a));
    if (std::abs(p.dot(along)) < wall_band_radii * r && p.norm() < wall_reach_radii * r && area.norm() > 0)
      spread += area * area.transpose() / area.norm();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  Vec3 normal = axes.eigenvectors().col(0);
  if (normal.dot(along) < 0)
    normal = -normal;
  return normal.dot(along) > least_agreement_cosine ? normal : along;
}

} // namespace anatomy
