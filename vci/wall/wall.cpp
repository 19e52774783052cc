#include "vci/wall/wall.hpp"
#include "common/error.hpp"
#include "vci/mechanics/hinge.hpp"
#include "vci/wall/foundation.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

constexpr double thinnest_plaque = 0.05; // mm: below it the plaque layer is left out

/// The law of a layer of `thickness` at `ratio` times the lumen's radius; modulus in MPa, thickness in mm.
HenckyLaw at_depth(HenckyLaw law, double modulus, double thickness, double ratio) {
  law.stiffness = modulus * thickness * ratio;
  law.depth = ratio * ratio - 1;
  return law;
}

} // namespace

std::array<HenckyLaw, 2> plaque_layers(const HenckyLaw& law, double modulus, double thickness, double radius) {
  constexpr double gauss[2] = {0.2113248654051871, 0.7886751345948129};
  const double widest = 1 + thickness / radius;
  const auto layer = [&](double place) {
    const double ratio = std::pow(widest, place);
    return at_depth(law, modulus, 0.5 * radius * ratio * std::log(widest), ratio);
  };
  return {layer(gauss[0]), layer(gauss[1])};
}

Wall add_wall(System& system, const Lumen& lumen, const std::vector<char>& free, const WallSpec& spec, double map_pa) {
  Wall wall{};
  std::vector<char> cap(lumen.points.size(), 0);
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k)
    if (lumen.region[k] != 0)
      for (int v : lumen.triangles[k])
        cap[v] = 1;
  std::vector<int> local(lumen.points.size(), -1);
  Triangles triangles;
  const auto moves = [&](int v) { return free[v] && !cap[v]; };
  for (std::size_t k = 0; k < lumen.triangles.size(); ++k) {
    const Triangle& t = lumen.triangles[k];
    if (lumen.region[k] != 0 || !std::any_of(t.begin(), t.end(), moves))
      continue;
    Triangle own;
    for (int i = 0; i < 3; ++i) {
      if (local[t[i]] < 0) {
        local[t[i]] = static_cast<int>(wall.vertex.size());
        wall.vertex.push_back(t[i]);
      }
      own[i] = local[t[i]];
    }
    triangles.push_back(own);
    wall.triangle.push_back(static_cast<int>(k));
  }
  if (triangles.empty())
    throw common::InputError("no wall lies near the devices", "procedure", "0 triangles",
                             "check branch and centre_s_mm");
  Vectors points;
  std::vector<char> fixed;
  for (int v : wall.vertex) {
    points.push_back(lumen.points[v]);
    fixed.push_back(!moves(v));
  }
  wall.fixed = static_cast<int>(std::count(fixed.begin(), fixed.end(), 1));

  std::vector<HenckyLaw> intima;
  std::array<std::vector<HenckyLaw>, 2> plaque;
  Triangles with_plaque;
  for (const Triangle& t : triangles) {
    double thickness = 0, modulus = 0, weight = 0, radius = 0;
    int type = 0;
    for (int v : t) { // the stiffest type at a corner names the law, the moduli are averaged over the plaque there
      const int g = wall.vertex[v];
      thickness += lumen.plaque[g] / 3.0;
      radius += lumen.radius[g] / 3.0;
      if (lumen.plaque_type[g] > 0) {
        modulus += lumen.plaque[g] * spec.plaque[lumen.plaque_type[g]].youngs_modulus;
        weight += lumen.plaque[g];
        if (type == 0 || spec.plaque[lumen.plaque_type[g]].youngs_modulus > spec.plaque[type].youngs_modulus)
          type = lumen.plaque_type[g];
      }
    }
    const bool bare = thickness < thinnest_plaque || type == 0 || weight <= 0;
    // healthy intima lies behind the plaque, where the wall stretches less than the lumen
    intima.push_back(at_depth({0, spec.poisson_ratio, spec.stiffening}, spec.youngs_modulus, spec.intima_thickness,
                              bare ? 1 : 1 + thickness / radius));
    if (bare)
      continue;
    with_plaque.push_back(t);
    const PlaqueSpec& p = spec.plaque[type];
    const auto layers =
        plaque_layers({0, spec.poisson_ratio, 0, p.yield_strain, p.hardening}, modulus / weight, thickness, radius);
    for (std::size_t k = 0; k < layers.size(); ++k)
      plaque[k].push_back(layers[k]);
  }
  const int body =
      system.add_body("wall", points, triangles, spec.density * (spec.intima_thickness + spec.media_thickness), fixed);
  wall.intima = &add_layer(system, body, spec, triangles, points, std::move(intima));
  if (!with_plaque.empty())
    for (const std::vector<HenckyLaw>& layer : plaque)
      add_layer(system, body, spec, with_plaque, points, layer);
  const double t = spec.intima_thickness + spec.media_thickness;
  const double rigidity = spec.youngs_modulus * t * t * t / (12 * (1 - spec.poisson_ratio * spec.poisson_ratio));
  const std::vector<EdgePair> edges = interior_edges(triangles, points);
  system.add_force(
      body, std::make_unique<Hinges>(edges, points, shell_coefficients(edges, points, rigidity), spec.hinge_yield));

  const Vectors areas = vertex_area_vectors(triangles, points, 0, static_cast<int>(points.size()));
  std::vector<RingFoundation::Element> rings;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int g = wall.vertex[i];
    const RingLaw law{spec.youngs_modulus * spec.media_thickness,
                      spec.stiffening,
                      spec.tissue_modulus / (1 + spec.poisson_ratio),
                      spec.tangential_stiffness,
                      map_pa * mpa_per_pa,
                      lumen.radius[g],
                      lumen.radius[g] + lumen.plaque[g]};
    rings.push_back({static_cast<int>(i), points[i], areas[i].normalized(), system.area[i], law});
  }
  system.add_force(body, std::make_unique<RingFoundation>(std::move(rings), triangles));
  return wall;
}

Vectors moved_points(const Lumen& lumen, const Wall& wall, const System& system) {
  Vectors points = lumen.points;
  for (std::size_t i = 0; i < wall.vertex.size(); ++i)
    points[wall.vertex[i]] = system.x[i];
  return points;
}

} // namespace vci
