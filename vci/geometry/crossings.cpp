#include "vci/geometry/crossings.hpp"

#include <algorithm>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>
#include <limits>

namespace vci {

namespace {

using Model = fcl::BVHModel<fcl::OBBRSS<double>>;

template <class TriangleAt>
void build(Model& model, std::size_t count, const TriangleAt& triangle_at, const Vectors& x) {
  model.beginModel(static_cast<int>(count), static_cast<int>(3 * count));
  for (std::size_t k = 0; k < count; ++k) {
    const Triangle& t = triangle_at(k);
    model.addTriangle(x[t[0]], x[t[1]], x[t[2]]);
  }
  model.endModel();
}

} // namespace

Crossings self_crossings(const Triangles& triangles, const std::vector<int>& some, const Vectors& x) {
  Crossings found;
  if (some.empty())
    return found;
  Model chosen, all;
  build(
      chosen, some.size(), [&](std::size_t k) -> const Triangle& { return triangles[some[k]]; }, x);
  build(
      all, triangles.size(), [&](std::size_t k) -> const Triangle& { return triangles[k]; }, x);
  fcl::CollisionRequest<double> request(std::numeric_limits<std::size_t>::max());
  fcl::CollisionResult<double> result;
  const fcl::Transform3d here = fcl::Transform3d::Identity();
  fcl::collide(&chosen, here, &all, here, request, result);
  int first = std::numeric_limits<int>::max();
  for (std::size_t k = 0; k < result.numContacts(); ++k) {
    const int a = some[result.getContact(k).b1], b = static_cast<int>(result.getContact(k).b2);
    const Triangle &s = triangles[a], &t = triangles[b];
    if (std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end())
      continue; // triangles that share a vertex touch there
    if (b < a && std::binary_search(some.begin(), some.end(), b))
      continue; // found from the other triangle, too
    ++found.pairs;
    if (a < first) {
      first = a;
      found.first = x[s[0]];
    }
  }
  return found;
}

} // namespace vci
