#include "vci/geometry/arrays.hpp"
#include "common/error.hpp"

#include <algorithm>
#include <cmath>

namespace vci {

namespace {

void check_length(const std::string& name, std::size_t length, std::size_t points) {
  if (length != points)
    throw common::InputError("an array of another length than the points", name, std::to_string(length),
                             "give one value for each of the " + std::to_string(points) + " points");
}

/// The values, or zeros if none are given. Throws if their number is wrong, or if one is not within [0, largest].
template <class Value>
std::vector<Value> checked_values(const std::string& name, const std::vector<Value>& values, std::size_t points,
                                  Value largest) {
  if (values.empty())
    return std::vector<Value>(points, Value(0));
  check_length(name, values.size(), points);
  for (std::size_t k = 0; k < points; ++k)
    if (!(values[k] >= 0 && values[k] <= largest))
      throw common::InputError("a value out of its range", name + "[" + std::to_string(k) + "]",
                               std::to_string(values[k]), "give 0 to " + std::to_string(largest));
  return values;
}

} // namespace

Vectors vectors_of(const Eigen::Ref<const PointRows>& points) {
  Vectors vectors;
  for (Eigen::Index k = 0; k < points.rows(); ++k)
    vectors.emplace_back(points.row(k).transpose());
  return vectors;
}

PointRows rows_of(const Vectors& points) {
  PointRows rows(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t k = 0; k < points.size(); ++k)
    rows.row(static_cast<Eigen::Index>(k)) = points[k].transpose();
  return rows;
}

Lumen lumen_from(const Eigen::Ref<const PointRows>& points, const Eigen::Ref<const TriangleRows>& triangles,
                 const std::vector<double>& radius, const std::vector<double>& plaque,
                 const std::vector<int>& plaque_type, const std::vector<double>& reference_radius,
                 const std::vector<int>& branch) {
  constexpr double largest_mm = 20; // largest radius or plaque thickness accepted, the same as in files
  Lumen lumen;
  lumen.points = vectors_of(points);
  const std::size_t count = lumen.points.size();
  if (!points.allFinite())
    throw common::InputError("a coordinate is not finite", "points", "nan or infinity", "give points in mm");
  check_length("radius", radius.size(), count);
  lumen.radius = checked_values("radius", radius, count, largest_mm);
  if (std::any_of(radius.begin(), radius.end(), [](double r) { return r <= 0; }))
    throw common::InputError("a radius of nothing", "radius", "0", "give the local radius of the lumen in mm");
  lumen.plaque = checked_values("plaque", plaque, count, largest_mm);
  lumen.plaque_type = checked_values("plaque_type", plaque_type, count, 3);
  if (!reference_radius.empty())
    lumen.reference_radius = checked_values("reference_radius", reference_radius, count, largest_mm);
  for (Eigen::Index k = 0; k < triangles.rows(); ++k) {
    const Triangle t{triangles(k, 0), triangles(k, 1), triangles(k, 2)};
    if (std::any_of(t.begin(), t.end(), [&](int v) { return v < 0 || static_cast<std::size_t>(v) >= count; }))
      throw common::InputError("a triangle that names a point which is not there",
                               "triangles[" + std::to_string(k) + "]",
                               std::to_string(t[0]) + ", " + std::to_string(t[1]) + ", " + std::to_string(t[2]),
                               "give indices from 0 to " + std::to_string(count) + " - 1");
    lumen.triangles.push_back(t);
  }
  lumen.region.assign(lumen.triangles.size(), 0);
  if (!branch.empty() && branch.size() != lumen.triangles.size())
    throw common::InputError("a number of values that is not that of the triangles", "branch_id",
                             std::to_string(branch.size()),
                             "give one value for each of the " + std::to_string(lumen.triangles.size()) + " triangles");
  lumen.branch = branch;
  return lumen;
}

} // namespace vci
