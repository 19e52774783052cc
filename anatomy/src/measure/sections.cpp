#include "measure/sections.hpp"
#include "common/error.hpp"
#include "core/slices.hpp"
#include "measure/outline_noise.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace anatomy {
namespace {

constexpr double arc_step = pi / 60; // angle between points of the curve that closes a section across a mouth

Vec2 centroid(const std::vector<Vec2>& loop) {
  Vec2 sum = Vec2::Zero();
  double area = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    const double cross = a.x() * b.y() - a.y() * b.x();
    sum += cross * (a + b) / 6;
    area += cross / 2;
  }
  return sum / area;
}

// Distance (mm) from the point `from` to the loop along the unit vector d: the farthest crossing, 0 if there is none.
double ray_length(const std::vector<Vec2>& loop, const Vec2& from, const Vec2& d) {
  double farthest = 0;
  const Vec2 n(-d.y(), d.x());
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 a = loop[i] - from, b = loop[(i + 1) % loop.size()] - from;
    const double ha = a.dot(n), hb = b.dot(n);
    if ((ha > 0) != (hb > 0))
      farthest = std::max(farthest, (a + ha / (ha - hb) * (b - a)).dot(d));
  }
  return farthest;
}

// Sets the smallest and the largest chord through the centroid, among chords at every 3 degrees.
void set_diameters(Section& section, const std::vector<Vec2>& loop) {
  const Vec2 c = centroid(loop);
  section.min_diameter = 1e300;
  for (int k = 0; k < 60; ++k) {
    const double angle = k * pi / 60;
    const Vec2 d(std::cos(angle), std::sin(angle));
    const double chord = ray_length(loop, c, d) + ray_length(loop, c, -d);
    section.min_diameter = std::min(section.min_diameter, chord);
    section.max_diameter = std::max(section.max_diameter, chord);
  }
}

double turn(const Vec2& a, const Vec2& b) {
  return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
}

// The conic a x^2 + b x y + c y^2 + d x + e y = 1 that fits an outline round the origin best; mostly an ellipse.
class FittedConic {
  using Coefficients = Eigen::Matrix<double, 5, 1>;

public:
  // Points (mm) on the outline, and the weight of each.
  FittedConic(const std::vector<Vec2>& points, const std::vector<double>& weights) {
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Coefficients right = Coefficients::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double x = points[i].x(), y = points[i].y();
      const Coefficients row{x * x, x * y, y * y, x, y};
      normal += weights[i] * row * row.transpose();
      right += weights[i] * row;
    }
    k_ = normal.ldlt().solve(right);
  }
  // Distance (mm) from the origin to the conic along the unit vector d; infinite if it is open there.
  double radius(const Vec2& d) const {
    const double squared = k_[0] * d.x() * d.x() + k_[1] * d.x() * d.y() + k_[2] * d.y() * d.y();
    const double linear = k_[3] * d.x() + k_[4] * d.y(), root = linear * linear + 4 * squared;
    const double twice_inverse = root < 0 ? 0 : linear + std::sqrt(root);
    return twice_inverse > 0 ? 2 / twice_inverse : std::numeric_limits<double>::infinity();
  }

private:
  Coefficients k_;
};

// A section's outline in the plane, closed across the mouths of other branches. The axis is the origin.
// in_mouth: for each point of the loop, whether it lies on the wall of another branch or of a stub; inscribed: mm,
// radius of the sphere there. Across a mouth the outline follows the conic that fits the rest of it. The wall flares
// towards a mouth, which widens the conic there. So its radius is at most that of the wall on the opposite side. It is
// at least that of the sphere.
std::vector<Vec2> close_mouths(std::vector<Vec2> loop, std::vector<bool> in_mouth, double inscribed) {
  if (signed_area(loop) < 0) {
    std::reverse(loop.begin(), loop.end());
    std::reverse(in_mouth.begin(), in_mouth.end());
  }
  const auto first = std::find(in_mouth.begin(), in_mouth.end(), false) - in_mouth.begin();
  if (first == std::ptrdiff_t(loop.size())) { // all is mouth: only the sphere is known
    for (Vec2& q : loop)
      q *= inscribed / q.norm();
    return loop;
  }
  std::rotate(loop.begin(), loop.begin() + first, loop.end());
  std::rotate(in_mouth.begin(), in_mouth.begin() + first, in_mouth.end());
  loop.push_back(loop.front());
  in_mouth.push_back(false);
  std::vector<Vec2> wall;
  std::vector<double> angles;
  for (std::size_t i = 0; i + 1 < loop.size(); ++i)
    if (!in_mouth[i] && !in_mouth[i + 1]) {
      wall.push_back(0.5 * (loop[i] + loop[i + 1]));
      angles.push_back(std::abs(turn(loop[i], loop[i + 1])));
    }
  const FittedConic conic(wall, angles);
  std::vector<Vec2> closed;
  double width = 0; // angle that the outline has turned round the axis since the last edge of a mouth
  for (std::size_t i = 0; i + 1 < loop.size(); ++i) {
    if (!in_mouth[i])
      closed.push_back(loop[i]);
    width += turn(loop[i], loop[i + 1]);
    if (in_mouth[i + 1])
      continue;
    if (in_mouth[i]) {
      const Vec2 edge = closed.back().normalized();
      for (double angle = arc_step; angle < width; angle += arc_step) {
        const Vec2 d = Eigen::Rotation2Dd(angle) * edge;
        closed.push_back(std::max(inscribed, std::min(conic.radius(d), ray_length(wall, Vec2::Zero(), -d))) * d);
      }
    }
    width = 0;
  }
  return closed;
}

bool is_on_cap(const Vec3& p, const std::vector<End>& ends) {
  return std::any_of(ends.begin(), ends.end(), [&](const End& end) {
    return std::abs((p - end.centre).dot(end.normal)) < 1e-3 && (p - end.centre).norm() < 1.5 * end.radius();
  });
}

bool is_in_stub(const Vec3& p, std::size_t branch, const Vec3& on_axis, const std::vector<ClosedStub>& stubs) {
  return std::any_of(stubs.begin(), stubs.end(),
                     [&](const ClosedStub& stub) { return stub.branch == branch && stub.contains(p, on_axis); });
}

} // namespace

bool is_near_end(const Branch& branch, const std::vector<End>& ends, double s) {
  const auto inlet = std::find_if(ends.begin(), ends.end(), [](const End& end) { return end.inlet; });
  const double at_inlet = std::max(end_zone * branch.radius.front(), inlet == ends.end() ? 0 : inlet->extension);
  const double at_outlet = std::max(end_zone * branch.radius.back(), ends[branch.end].extension);
  return (branch.parent < 0 && s < at_inlet) || branch.axis.length() - s < at_outlet;
}

std::vector<Section> cut_sections(const Mesh& surface, const std::vector<Branch>& branches,
                                  const std::vector<End>& ends, int splits, const std::vector<ClosedStub>& stubs) {
  const Slices slices(surface);
  std::vector<Section> sections;
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const Branch& branch = branches[b];
    for (std::size_t i = 1; i + 1 < branch.s.size(); ++i) {
      if (branch.s[i] <= branch.s_outside && branch.parent >= 0)
        continue;
      const PlaneFrame frame(branch.x[i], branch.axis.tangent(branch.s[i]));
      const std::vector<Vec3> loop = slices.loop_around(frame);
      const bool end = is_near_end(branch, ends, branch.s[i]);
      if (loop.empty()) {
        if (end)
          continue;
        throw common::ComputationError("no cross-section contains the axis",
                                       branch.name + " at " + point_text(branch.x[i]),
                                       "s = " + std::to_string(branch.s[i]) + " mm", "use a smaller edge");
      }
      Section section;
      section.branch = b;
      section.sample = i;
      section.flag = end ? SectionFlag::end : SectionFlag::ok;
      std::vector<Vec2> flat;
      std::vector<bool> in_mouth;
      for (const Vec3& p : loop) {
        flat.push_back(frame.plane(p));
        if (is_on_cap(p, ends))
          section.flag = SectionFlag::end;
        in_mouth.push_back(
            flat.back().norm() > mouth_distance * branch.radius[i] &&
            (is_in_stub(p, b, branch.x[i], stubs) || (branches.size() > 1 && nearest_axis(branches, p).branch != b)));
      }
      if (std::find(in_mouth.begin(), in_mouth.end(), true) != in_mouth.end()) {
        flat = close_mouths(flat, in_mouth, branch.radius[i]);
        if (section.flag == SectionFlag::ok)
          section.flag = SectionFlag::ostium;
      }
      section.area = std::abs(signed_area(flat));
      set_diameters(section, flat);
      if (section.flag == SectionFlag::ok)
        section.scatter = mean_radius_scatter(flat, splits * edge_by_crossings(flat));
      sections.push_back(section);
    }
  }
  return sections;
}

} // namespace anatomy
