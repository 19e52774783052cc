#include "vci/geometry/crossings.hpp"

#include <algorithm>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>
#include <limits>

namespace vci {

Crossings self_crossings(const Triangles& triangles, const Vectors& x) {
  using Model = fcl::BVHModel<fcl::OBBRSS<double>>;
  Model model;
  model.beginModel(static_cast<int>(triangles.size()), static_cast<int>(x.size()));
  for (const Triangle& t : triangles)
    model.addTriangle(x[t[0]], x[t[1]], x[t[2]]);
  model.endModel();
  fcl::CollisionRequest<double> request(std::numeric_limits<std::size_t>::max());
  fcl::CollisionResult<double> result;
  const fcl::Transform3d here = fcl::Transform3d::Identity();
  fcl::collide(&model, here, &model, here, request, result);
  Crossings found;
  int first = std::numeric_limits<int>::max();
  for (std::size_t k = 0; k < result.numContacts(); ++k) {
    const auto& contact = result.getContact(k);
    const int a = static_cast<int>(contact.b1), b = static_cast<int>(contact.b2);
    const Triangle &s = triangles[a], &t = triangles[b];
    if (a >= b || std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end())
      continue; // each pair is found twice, and triangles that share a vertex touch there
    ++found.pairs;
    if (a < first) {
      first = a;
      found.first = x[s[0]];
    }
  }
  return found;
}

} // namespace vci
