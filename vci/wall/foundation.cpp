#include "vci/wall/foundation.hpp"
#include "vci/geometry/surface.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

std::array<double, 2> RingLaw::pressure_and_slope(double u) const {
  const double a = lumen_radius + std::max(u, 0.0);
  const double b = std::sqrt(tissue_radius * tissue_radius + a * a - lumen_radius * lumen_radius);
  const double e = b / tissue_radius - 1.0;
  const double db = a / b, de = db / tissue_radius;
  const double tension = tissue_modulus * e * b + blood_pressure * (lumen_radius - a);
  const double slope = tissue_modulus * (de * b + e * db) - blood_pressure;
  const double inwards = std::min(u, 0.0);
  return {(tension + slope * inwards) / lumen_radius, slope / lumen_radius};
}

namespace {

template <class Element> std::vector<int> vertices_of(const std::vector<Element>& elements) {
  std::vector<int> vertices;
  for (const Element& e : elements)
    vertices.push_back(e.vertex);
  return vertices;
}

} // namespace

RingFoundation::RingFoundation(std::vector<Element> elements, Triangles triangles)
    : VertexForce(vertices_of(elements)), elements_(std::move(elements)), triangles_(std::move(triangles)) {}

double RingFoundation::energy(const Vectors& x) const {
  // places and weights of four Gauss points on [0, 1], for the integral of the pressure from 0 to u
  static const double place[4] = {0.069431844202973712, 0.330009478207571868, 0.669990521792428132,
                                  0.930568155797026288};
  static const double weight[4] = {0.173927422568726929, 0.326072577431273071, 0.326072577431273071,
                                   0.173927422568726929};
  double sum = 0;
  for (const Element& e : elements_) {
    const Vec3 d = x[e.vertex] - e.origin;
    const double u = d.dot(e.normal);
    double work = 0;
    for (int k = 0; k < 4; ++k)
      work += weight[k] * u * e.law.pressure_and_slope(place[k] * u)[0];
    sum += e.area * (work + 0.5 * e.law.tangential_stiffness * (d.squaredNorm() - u * u));
  }
  return sum;
}

void RingFoundation::evaluate(const Vectors& x, Vectors& force, BlockMatrix* stiffness, bool exact) const {
  const Vectors normals = vertex_area_vectors(triangles_, x, 0, triangles_.empty() ? 0 : static_cast<int>(x.size()));
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const Element& e = elements_[k];
    const Vec3 d = x[e.vertex] - e.origin;
    const double u = d.dot(e.normal);
    const Vec3 direction = normals.empty() ? e.normal : normals[e.vertex].normalized();
    const auto [pressure, slope] = e.law.pressure_and_slope(u);
    const double tangential = e.law.tangential_stiffness;
    force[e.vertex] -= e.area * (pressure * direction + tangential * (d - u * e.normal));
    if (!stiffness)
      continue;
    const double normal_part = (exact ? slope : std::max(slope, 0.0)) - tangential;
    Mat3& block = stiffness->block(slots_[k]);
    block += e.area * normal_part * e.normal * e.normal.transpose();
    block.diagonal().array() += e.area * tangential;
  }
}

} // namespace vci
