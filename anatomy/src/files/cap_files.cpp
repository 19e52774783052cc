#include "files/cap_files.hpp"
#include "common/error.hpp"
#include "files/surface_file.hpp"

namespace anatomy {
namespace {

using common::InputError;

GivenCap measure_cap(const std::string& path, const Soup& soup) {
  GivenCap cap{path, Vec3::Zero(), 0, soup};
  double weight = 0;
  Vec3 total = Vec3::Zero();
  for (const Triangle& t : soup.triangles) {
    const Vec3 a = vec(soup.points[t[0]]), b = vec(soup.points[t[1]]), c = vec(soup.points[t[2]]);
    Vec3 area = 0.5 * (b - a).cross(Vec3(c - a));
    if (area.dot(total) < 0) // the orientation of the file's triangles may vary
      area = -area;
    total += area;
    weight += area.norm();
    cap.centre += area.norm() * (a + b + c) / 3;
  }
  cap.centre /= weight;
  cap.area = total.norm();
  if (!(cap.area > 0))
    throw InputError("the cap has no area", path, std::to_string(soup.triangles.size()) + " triangles",
                     "export the face that closes this end as triangles, or name the end by a point (inlet_point_mm, "
                     "outlet_points_mm in a case file)");
  return cap;
}

} // namespace

std::vector<GivenCap> read_caps(const std::vector<std::string>& paths, LengthUnit unit) {
  std::vector<GivenCap> caps;
  for (const std::string& path : paths)
    caps.push_back(measure_cap(path, soup_of(read_triangles(path, unit))));
  return caps;
}

} // namespace anatomy
