#include "vci/wall/wall.hpp"
#include "common/error.hpp"
#include "vci/mechanics/hinge.hpp"
#include "vci/wall/foundation.hpp"
#include "vci/wall/septum.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr int calcified = 3;                    // plaque_type
constexpr double least_plaque_thickness = 0.05; // mm: a triangle with thinner plaque gets no plaque layers

/// Completes the law of a layer with its stiffness and depth.
/// @param modulus MPa
/// @param thickness mm
/// @param ratio radius of the layer over the lumen's radius
HenckyLaw law_at_depth(HenckyLaw law, double modulus, double thickness, double ratio) {
  law.stiffness = modulus * thickness * ratio;
  law.depth = ratio * ratio - 1;
  return law;
}

} // namespace

std::array<HenckyLaw, 2> plaque_layers(const HenckyLaw& law, double modulus, double thickness, double radius) {
  constexpr double gauss_points[2] = {0.2113248654051871, 0.7886751345948129};
  const double outer_ratio = 1 + thickness / radius;
  const auto layer = [&](double place) {
    const double ratio = std::pow(outer_ratio, place);
    return law_at_depth(law, modulus, 0.5 * radius * ratio * std::log(outer_ratio), ratio);
  };
  return {layer(gauss_points[0]), layer(gauss_points[1])};
}

namespace {

/// The moving part of the lumen: its points, its triangles as indices into these points, and a flag for each point that
/// is held in place.
struct MovingPart {
  Vectors points;
  Triangles triangles;
  std::vector<char> fixed;
};

/// @param may_move whether each of the lumen's points may move
/// @param wall receives the numbers in the lumen of the moving part's vertices and triangles
MovingPart moving_part(const Lumen& lumen, const std::vector<char>& may_move, Wall& wall) {
  std::vector<char> cap(lumen.points.size(), 0);
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k)
    if (lumen.region[k] != 0)
      for (int v : lumen.triangles[k])
        cap[v] = 1;
  const auto moves = [&](int v) { return may_move[v] && !cap[v]; };
  std::vector<int> local(lumen.points.size(), -1);
  MovingPart part;
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k) {
    const Triangle& t = lumen.triangles[k];
    if (lumen.region[k] != 0 || !std::any_of(t.begin(), t.end(), moves))
      continue;
    Triangle own;
    for (int i = 0; i < 3; ++i) {
      if (local[t[i]] < 0) {
        local[t[i]] = static_cast<int>(wall.lumen_vertex.size());
        wall.lumen_vertex.push_back(t[i]);
        part.points.push_back(lumen.points[t[i]]);
        part.fixed.push_back(!moves(t[i]));
      }
      own[i] = local[t[i]];
    }
    part.triangles.push_back(own);
    wall.lumen_triangle.push_back(static_cast<int>(k));
  }
  if (part.triangles.empty())
    throw common::InputError("no wall lies near the devices", "procedure", "0 triangles",
                             "check branch and centre_s_mm");
  return part;
}

/// Plaque of a triangle. Values are means over the corners; the modulus is weighted by the thickness. The stiffest type
/// at a corner gives the yield law.
struct TrianglePlaque {
  double thickness = 0, modulus = 0, radius = 0; ///< mm, MPa; radius of the lumen, mm
  int type = 0;                                  ///< 0: no plaque, or too thin for plaque layers
};

TrianglePlaque triangle_plaque(const Triangle& t, const Lumen& lumen, const Wall& wall, const WallSpec& spec) {
  TrianglePlaque plaque;
  double modulus = 0, weight = 0;
  for (int v : t) {
    const int g = wall.lumen_vertex[v], type = lumen.plaque_type[g];
    plaque.thickness += lumen.plaque[g] / 3.0;
    plaque.radius += lumen.radius[g] / 3.0;
    if (type > 0) {
      modulus += lumen.plaque[g] * spec.plaque[type].youngs_modulus;
      weight += lumen.plaque[g];
      if (plaque.type == 0 || spec.plaque[type].youngs_modulus > spec.plaque[plaque.type].youngs_modulus)
        plaque.type = type;
    }
  }
  if (plaque.thickness < least_plaque_thickness || weight <= 0)
    plaque.type = 0;
  plaque.modulus = modulus / weight;
  return plaque;
}

/// Adds the healthy wall, that is intima and media, and two layers of plaque on triangles that have any. Returns the
/// healthy wall, whose stretch is reported.
const Layer* add_wall_layers(System& system, int body, const MovingPart& part, const Lumen& lumen, const Wall& wall,
                             const WallSpec& spec) {
  std::vector<HenckyLaw> healthy;
  std::array<std::vector<HenckyLaw>, 2> plaque;
  Triangles with_plaque;
  for (const Triangle& t : part.triangles) {
    const TrianglePlaque own = triangle_plaque(t, lumen, wall, spec);
    // The healthy wall lies outside the plaque, where it stretches less than the lumen.
    healthy.push_back(law_at_depth({0, spec.poisson_ratio, spec.stiffening}, spec.youngs_modulus, spec.thickness,
                                   own.type == 0 ? 1 : 1 + own.thickness / own.radius));
    if (own.type == 0)
      continue;
    with_plaque.push_back(t);
    const PlaqueSpec& p = spec.plaque[own.type];
    const auto layers =
        plaque_layers({0, spec.poisson_ratio, 0, p.yield_strain, p.hardening}, own.modulus, own.thickness, own.radius);
    for (std::size_t k = 0; k < layers.size(); ++k)
      plaque[k].push_back(layers[k]);
  }
  const Layer* healthy_layer = &add_layer(system, body, spec, part.triangles, part.points, std::move(healthy));
  if (!with_plaque.empty())
    for (const std::vector<HenckyLaw>& layer : plaque)
      add_layer(system, body, spec, with_plaque, part.points, layer);
  return healthy_layer;
}

/// Bending of the wall at a vertex.
struct PlateBending {
  double rigidity;        ///< N mm
  double yield_curvature; ///< 1/mm: change of curvature at which a plate is plastic through its thickness; 0: no plate
};

/// Adds the bending stiffness of the healthy wall and of sheets of calcium. The healthy wall lies outside the plaque,
/// where its triangles are wider than those of the lumen; the angles between them are those of the lumen. Calcium bends
/// as a plate. It keeps its area, so it thins as the lumen opens; its thickness here is that on a lumen opened to the
/// media. Softer plaque yields before it bends much, and adds no stiffness.
void add_bending(System& system, int body, const MovingPart& part, const Lumen& lumen, const Wall& wall,
                 const WallSpec& spec) {
  const auto rigidity = [&](double modulus, double t) {
    return modulus * t * t * t / (12 * (1 - spec.poisson_ratio * spec.poisson_ratio));
  };
  const Vectors areas = vertex_area_vectors(part.triangles, part.points, 0, static_cast<int>(part.points.size()));
  Vectors outside_plaque = part.points;
  std::vector<PlateBending> calcium(areas.size(), PlateBending{0, 0});
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const int g = wall.lumen_vertex[i];
    outside_plaque[i] += lumen.plaque[g] * areas[i].normalized();
    if (lumen.plaque_type[g] != calcified || lumen.plaque[g] < least_plaque_thickness)
      continue;
    const double a = lumen.radius[g], b = a + lumen.plaque[g], opened = std::sqrt(2 * b * b - a * a) - b;
    const PlaqueSpec& p = spec.plaque[calcified];
    calcium[i] = {rigidity(p.youngs_modulus, opened), 3 * p.yield_strain / opened};
  }
  const std::vector<InteriorEdge> edges = interior_edges(part.triangles, part.points),
                                  outside = interior_edges(part.triangles, outside_plaque);
  std::vector<double> coefficients = shell_coefficients(outside, outside_plaque, 1), yield_angles;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const PlateBending &p = calcium[edges[k].e0], &q = calcium[edges[k].e1];
    const double width = outside[k].rest_length / coefficients[k]; // an angle is a curvature times this
    const double yield_curvature = std::max(p.yield_curvature, q.yield_curvature);
    yield_angles.push_back(yield_curvature > 0 ? yield_curvature * width : spec.hinge_yield);
    coefficients[k] *= rigidity(spec.youngs_modulus, spec.thickness) + 0.5 * (p.rigidity + q.rigidity);
  }
  system.add_force(body, std::make_unique<Hinges>(edges, part.points, coefficients, yield_angles));
}

/// Adds the surrounding tissue and the prestress by blood pressure.
/// @param map_pa mean blood pressure, Pa
void add_foundation(System& system, int body, const MovingPart& part, const Lumen& lumen, const Wall& wall,
                    const WallSpec& spec, double map_pa) {
  const Vectors areas = vertex_area_vectors(part.triangles, part.points, 0, static_cast<int>(part.points.size()));
  std::vector<RingFoundation::Element> rings;
  for (std::size_t i = 0; i < part.points.size(); ++i) {
    const int g = wall.lumen_vertex[i];
    const RingLaw law{spec.tissue_modulus / (1 + spec.poisson_ratio), spec.tangential_stiffness, map_pa * mpa_per_pa,
                      lumen.radius[g], lumen.radius[g] + lumen.plaque[g]};
    rings.push_back({static_cast<int>(i), part.points[i], areas[i].normalized(), system.area[i], law});
  }
  system.add_force(body, std::make_unique<RingFoundation>(std::move(rings), part.triangles));
}

/// Adds the tissue between branches.
void add_septa(System& system, int body, const MovingPart& part, const Lumen& lumen, const Wall& wall,
               const WallSpec& spec) {
  std::vector<int> branch;
  if (!lumen.branch.empty())
    for (int triangle : wall.lumen_triangle)
      branch.push_back(lumen.branch[triangle]);
  const SeptumTissue tissue{spec.thickness, spec.youngs_modulus, spec.tissue_modulus};
  std::vector<Septum::Element> elements = septum_elements(part.triangles, part.points, branch, tissue);
  if (!elements.empty())
    system.add_force(body, std::make_unique<Septum>(std::move(elements), spec.poisson_ratio));
}

} // namespace

Wall add_wall(System& system, const Lumen& lumen, const std::vector<char>& may_move, const WallSpec& spec,
              double map_pa) {
  Wall wall{};
  const MovingPart part = moving_part(lumen, may_move, wall);
  const double surface_density = spec.density * spec.thickness;
  const int body = system.add_body("wall", part.points, part.triangles, surface_density, part.fixed);
  wall.healthy_layer = add_wall_layers(system, body, part, lumen, wall, spec);
  add_bending(system, body, part, lumen, wall, spec);
  add_foundation(system, body, part, lumen, wall, spec, map_pa);
  add_septa(system, body, part, lumen, wall, spec);
  return wall;
}

Vectors current_lumen_points(const Lumen& lumen, const Wall& wall, const System& system) {
  Vectors points = lumen.points;
  for (std::size_t i = 0; i < wall.lumen_vertex.size(); ++i)
    points[wall.lumen_vertex[i]] = system.x[i];
  return points;
}

} // namespace vci
