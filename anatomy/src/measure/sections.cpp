#include "measure/sections.hpp"
#include "common/error.hpp"
#include "core/slices.hpp"
#include "measure/outline_noise.hpp"
#include <algorithm>

namespace anatomy {
namespace {

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
    const double angle = k * M_PI / 60;
    const Vec2 d(std::cos(angle), std::sin(angle));
    const double chord = ray_length(loop, c, d) + ray_length(loop, c, -d);
    section.min_diameter = std::min(section.min_diameter, chord);
    section.max_diameter = std::max(section.max_diameter, chord);
  }
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
      section.flag = end ? "end" : "ok";
      std::vector<Vec2> flat;
      for (const Vec3& p : loop) {
        Vec2 q = frame.plane(p);
        if (is_on_cap(p, ends))
          section.flag = "end";
        const double limit = ostium_clip * branch.radius[i];
        if (q.norm() > limit &&
            (is_in_stub(p, b, branch.x[i], stubs) || (branches.size() > 1 && nearest_axis(branches, p).branch != b))) {
          q *= limit / q.norm();
          if (section.flag == "ok")
            section.flag = "ostium";
        }
        flat.push_back(q);
      }
      section.area = std::abs(signed_area(flat));
      set_diameters(section, flat);
      if (section.flag == "ok")
        section.scatter = mean_radius_scatter(flat, splits * edge_by_crossings(flat));
      sections.push_back(section);
    }
  }
  return sections;
}

} // namespace anatomy
