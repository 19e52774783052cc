// Flat sheets for contact tests, and the change of force that a contact matrix predicts.
#pragma once
#include "force_checks.hpp"
#include "vci/contact/contact.hpp"
#include <cmath>

namespace contact_checks {

using namespace vci;

/// A flat sheet of n x n vertices `edge` apart in a plane of constant z, facing up or down.
inline void add_sheet(System& system, int n, double edge, const Vec3& corner, bool up) {
  Vectors points;
  Triangles triangles;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      points.push_back(corner + edge * Vec3(i, j, 0));
  for (int i = 0; i + 1 < n; ++i)
    for (int j = 0; j + 1 < n; ++j) {
      const int a = i * n + j, b = a + n, c = b + 1, d = a + 1;
      for (Triangle t : {Triangle{a, b, c}, Triangle{a, c, d}}) {
        if (!up)
          std::swap(t[1], t[2]);
        triangles.push_back(t);
      }
    }
  system.add_body("sheet", points, triangles, 1, std::vector<char>(points.size(), 0));
}

/// The change of the contact forces that their stiffness matrix predicts: minus the matrix times the displacement.
inline Vectors predicted_change(const std::vector<StencilStiffness>& stencils, const Vectors& dx) {
  Vectors f(dx.size(), Vec3::Zero());
  for (const StencilStiffness& stencil : stencils) {
    Vec3 r = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      r += stencil.weight[k] * dx[stencil.vertex[k]];
    for (int k = 0; k < 4; ++k)
      f[stencil.vertex[k]] -= stencil.weight[k] * (stencil.stiffness() * r);
  }
  return f;
}

inline std::vector<StencilStiffness> stencils_of(const std::vector<ContactPoint>& points) {
  std::vector<StencilStiffness> stencils;
  for (const ContactPoint& p : points)
    stencils.push_back(p.stencil);
  return stencils;
}

inline double norm(const Vectors& f) {
  double sum = 0;
  for (const Vec3& v : f)
    sum += v.squaredNorm();
  return std::sqrt(sum);
}

inline Vectors combined(const Vectors& a, double factor, const Vectors& b) {
  Vectors sum = a;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum[i] += factor * b[i];
  return sum;
}

} // namespace contact_checks
