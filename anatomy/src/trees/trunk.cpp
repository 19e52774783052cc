#include "trees/trunk.hpp"
#include <algorithm>
#include <numeric>

namespace anatomy {
namespace {

// A sphere counts as inscribed only if its centre is this far from the wall, as a share of its radius.
constexpr double least_clearance = 0.9;
// Edge of a grid cell, in units of least_radius. Of the spheres with centres in one cell only the largest is kept, so
// that fewer spheres stand for the trunk.
constexpr double cell_edge = 0.2;

} // namespace

std::optional<Trunk> Trunk::of(const InscribedSpheres& spheres, const WallTree& wall, double least_radius) {
  std::vector<std::size_t> wide;
  for (std::size_t i = 0; i < spheres.centre.size(); ++i)
    if (spheres.radius[i] > least_radius)
      wide.push_back(i);
  std::stable_sort(wide.begin(), wide.end(),
                   [&](std::size_t a, std::size_t b) { return spheres.radius[a] > spheres.radius[b]; });
  for (std::size_t i : wide)
    if (wall.distance(spheres.centre[i]) > least_clearance * spheres.radius[i])
      return Trunk(spheres, wall, i, least_radius);
  return std::nullopt;
}

Trunk::Trunk(const InscribedSpheres& spheres, const WallTree& wall, std::size_t largest, double least_radius)
    : spheres_(spheres), largest_(largest), paths_(cheapest_paths(spheres, largest)) {
  std::vector<bool> seen(spheres_.centre.size(), false);
  std::vector<std::size_t> front{largest_};
  std::map<std::array<long, 3>, std::size_t> in_cell;
  seen[largest_] = true;
  while (!front.empty()) {
    const std::size_t i = front.back();
    front.pop_back();
    std::array<long, 3> at;
    for (int k = 0; k < 3; ++k)
      at[static_cast<std::size_t>(k)] = std::lround(spheres_.centre[i][k] / (cell_edge * least_radius));
    const auto [place, first] = in_cell.emplace(at, i);
    if (!first && spheres_.radius[i] > spheres_.radius[place->second])
      place->second = i;
    for (std::size_t j : spheres_.neighbours[i])
      if (!seen[j] && spheres_.radius[j] > least_radius) {
        seen[j] = true;
        front.push_back(j);
      }
  }
  for (const auto& [at, i] : in_cell) {
    spheres_.radius[i] = std::min(spheres_.radius[i], wall.distance(spheres_.centre[i]));
    filling_spheres_.push_back(i);
  }
}

double Trunk::distance_outside(const Vec3& p) const {
  double least = unreached;
  for (std::size_t i : filling_spheres_)
    least = std::min(least, (p - spheres_.centre[i]).norm() - spheres_.radius[i]);
  return least;
}

Vec3 Trunk::centre_near(const Vec3& p) const {
  std::size_t best = largest_;
  double radius = 0;
  for (std::size_t i : filling_spheres_)
    if ((p - spheres_.centre[i]).norm() < spheres_.radius[i] && spheres_.radius[i] > radius) {
      best = i;
      radius = spheres_.radius[i];
    }
  return spheres_.centre[best];
}

std::vector<Vec3> Trunk::path_to(const Vec3& p) const {
  const auto nearest =
      std::min_element(filling_spheres_.begin(), filling_spheres_.end(), [&](std::size_t a, std::size_t b) {
        return (spheres_.centre[a] - p).squaredNorm() < (spheres_.centre[b] - p).squaredNorm();
      });
  const SpherePath path(spheres_, paths_, *nearest);
  return {path.points.rbegin(), path.points.rend()};
}

std::vector<Offshoot> Trunk::offshoots(double least_length) const {
  const std::size_t n = spheres_.centre.size();
  std::vector<bool> inside(n);
  for (std::size_t i = 0; i < n; ++i)
    inside[i] = paths_.cost[i] >= unreached || contains(spheres_.centre[i]);
  // distance (mm) of each sphere along its path from the place at which the path leaves the trunk
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return paths_.cost[a] < paths_.cost[b]; });
  std::vector<double> out(n, 0);
  for (std::size_t i : order)
    if (!inside[i]) {
      const std::size_t before = paths_.previous[i];
      out[i] = inside[before] ? distance_outside(spheres_.centre[i])
                              : out[before] + (spheres_.centre[i] - spheres_.centre[before]).norm();
    }
  std::vector<Offshoot> offshoots;
  std::vector<bool> seen = inside;
  for (std::size_t start = 0; start < n; ++start) {
    if (seen[start])
      continue;
    std::vector<std::size_t> members{start};
    seen[start] = true;
    for (std::size_t k = 0; k < members.size(); ++k)
      for (std::size_t j : spheres_.neighbours[members[k]])
        if (!seen[j]) {
          seen[j] = true;
          members.push_back(j);
        }
    const std::size_t tip = *std::max_element(members.begin(), members.end(),
                                              [&](std::size_t a, std::size_t b) { return out[a] < out[b]; });
    if (out[tip] < least_length)
      continue;
    SpherePath path(spheres_, paths_, tip);
    offshoots.push_back({std::move(path), out[tip], {}});
    for (std::size_t i : members)
      offshoots.back().spheres.emplace_back(spheres_.centre[i], spheres_.radius[i]);
  }
  std::stable_sort(offshoots.begin(), offshoots.end(),
                   [](const Offshoot& a, const Offshoot& b) { return a.outside_length > b.outside_length; });
  return offshoots;
}

} // namespace anatomy
