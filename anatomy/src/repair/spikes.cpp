#include "repair/spikes.hpp"
#include "core/measures.hpp"
#include <algorithm>

namespace anatomy {
namespace {

// A spike is at least as high as each of the first three limits.
constexpr double least_spike_slope = 0.5;   // in mean edge lengths; the sides of such a spike slope by 27 degrees
constexpr double least_spike_radii = 0.15;  // in mean radii of the lumen; a lower spike hardly changes a section
constexpr double least_outlier_ratio = 8;   // in units of the scatter of the vertices round it about a smooth wall
constexpr double least_ring_height = 0.35;  // in mean edge lengths; a vertex nearer to its ring's plane is not examined
constexpr std::size_t most_neighbours = 12; // a vertex with more is the apex of a fan over a whole end, not a spike
constexpr Eigen::Index quadric_terms = 6;   // coefficients of a quadric; three more points are needed for the scatter

// The neighbours of a vertex.
struct VertexRing {
  std::vector<Vertex> vertices;                    // in order round the vertex
  Vec3 mean = Vec3::Zero(), normal = Vec3::Zero(); // mean position (mm), unit normal
  double edge = 0; // mean distance (mm) between successive neighbours; a spike does not lengthen it
};

VertexRing ring_of(const Mesh& mesh, Vertex v) {
  VertexRing ring;
  for (Vertex w : mesh.vertices_around_target(mesh.halfedge(v)))
    ring.vertices.push_back(w);
  const double n = static_cast<double>(ring.vertices.size());
  for (Vertex w : ring.vertices)
    ring.mean += vec(mesh.point(w)) / n;
  for (std::size_t i = 0; i < ring.vertices.size(); ++i) {
    const Vec3 a = vec(mesh.point(ring.vertices[i])),
               b = vec(mesh.point(ring.vertices[(i + 1) % ring.vertices.size()]));
    ring.normal += (a - ring.mean).cross(Vec3(b - ring.mean));
    ring.edge += (b - a).norm() / n;
  }
  if (ring.normal.norm() > 0)
    ring.normal.normalize();
  return ring;
}

// Height (mm) of v over the mean of its ring, along the ring's normal.
double height_over_ring(const Mesh& mesh, Vertex v, const VertexRing& ring) {
  return ring.normal.dot(Vec3(vec(mesh.point(v)) - ring.mean));
}

// The height (mm) of v over the quadric fitted to the two rings of vertices round it, and the scatter (mm) of these
// vertices about the quadric. Both are 0 if the vertices are too few.
std::pair<double, double> height_over_quadric(const Mesh& mesh, Vertex v, const VertexRing& ring) {
  std::vector<Vertex> around = ring.vertices;
  for (Vertex w : ring.vertices)
    for (Vertex x : mesh.vertices_around_target(mesh.halfedge(w)))
      if (x != v && std::find(around.begin(), around.end(), x) == around.end())
        around.push_back(x);
  const auto rows = static_cast<Eigen::Index>(around.size());
  if (rows < quadric_terms + 3)
    return {0, 0};
  const Vec3 p = vec(mesh.point(v)), e = ring.normal.unitOrthogonal(), f = ring.normal.cross(e);
  Eigen::MatrixXd basis(rows, quadric_terms);
  Eigen::VectorXd height(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Vec3 q = vec(mesh.point(around[static_cast<std::size_t>(i)])) - p;
    const double x = e.dot(q), y = f.dot(q);
    basis.row(i) << 1, x, y, x * x, x * y, y * y;
    height[i] = ring.normal.dot(q);
  }
  const Eigen::VectorXd fit = basis.colPivHouseholderQr().solve(height);
  const double scatter = (basis * fit - height).norm() / std::sqrt(static_cast<double>(rows - quadric_terms));
  return {-fit[0], scatter};
}

// Whether a cap touches a vertex of the ring.
bool near_cap(const Mesh& mesh, const RegionMap& region, const VertexRing& ring) {
  for (Vertex w : ring.vertices)
    for (Face f : mesh.faces_around_target(mesh.halfedge(w)))
      if (region[f] != 0)
        return true;
  return false;
}

} // namespace

void flatten_spikes(Mesh& mesh, std::vector<Repair>& repairs) {
  const RegionMap region = region_map(mesh);
  const double radius = mean_radius(mesh);
  std::vector<std::pair<Vertex, Vec3>> moves;
  double highest = 0;
  Vec3 where = Vec3::Zero();
  for (Vertex v : mesh.vertices()) {
    const VertexRing ring = ring_of(mesh, v);
    if (ring.vertices.size() > most_neighbours ||
        std::abs(height_over_ring(mesh, v, ring)) < least_ring_height * ring.edge || near_cap(mesh, region, ring))
      continue;
    const auto [height, scatter] = height_over_quadric(mesh, v, ring);
    if (std::abs(height) <
        std::max({least_spike_slope * ring.edge, least_spike_radii * radius, least_outlier_ratio * scatter}))
      continue;
    moves.emplace_back(v, vec(mesh.point(v)) - height * ring.normal);
    if (std::abs(height) > highest) {
      highest = std::abs(height);
      where = vec(mesh.point(v));
    }
  }
  if (moves.empty())
    return;
  for (const auto& [v, p] : moves)
    mesh.point(v) = point(p);
  char detail[128];
  std::snprintf(detail, sizeof detail, "single vertices up to %.3f mm off the wall round them, the highest at %s",
                highest, point_text(where).c_str());
  repairs.push_back({"spikes flattened", moves.size(), detail});
}

Roughness roughness_of(const Mesh& mesh) {
  Roughness out;
  std::vector<double> off;
  double mean = 0;
  for (Vertex v : mesh.vertices()) {
    const VertexRing ring = ring_of(mesh, v);
    const double n = static_cast<double>(ring.vertices.size());
    off.push_back(height_over_ring(mesh, v, ring) /
                  std::sqrt(1 + 1 / n)); // the mean of n neighbours scatters too, which adds 1 / n
    mean += off.back() / static_cast<double>(mesh.number_of_vertices());
    out.edge += ring.edge / static_cast<double>(mesh.number_of_vertices());
  }
  double sum = 0, most = 0;
  std::size_t i = 0;
  for (Vertex v : mesh.vertices()) {
    const double d = std::abs(off[i++] - mean);
    sum += d * d;
    if (d > most) {
      most = d;
      out.at = vec(mesh.point(v));
    }
  }
  out.rms = std::sqrt(sum / static_cast<double>(mesh.number_of_vertices()));
  return out;
}

} // namespace anatomy
