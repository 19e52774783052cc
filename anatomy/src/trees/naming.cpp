#include "trees/naming.hpp"
#include "common/error.hpp"
#include <algorithm>

namespace anatomy {
namespace {

using common::InputError;

// Index of the end nearest to the point p (mm) that the user gave by an option. Throws InputError if p is farther from
// that end than three of its radii.
std::size_t end_near(const std::vector<End>& ends, const Vec3& p, const std::string& option) {
  const auto nearest = std::min_element(ends.begin(), ends.end(), [&](const End& a, const End& b) {
    return (a.centre - p).norm() < (b.centre - p).norm();
  });
  if ((nearest->centre - p).norm() > 3 * nearest->radius())
    throw InputError("no end of the vessel near the given point", option, point_text(p),
                     "the nearest end is at " + point_text(nearest->centre) + ": give a point near an end");
  return static_cast<std::size_t>(nearest - ends.begin());
}

// Number of a branch by its name: 0 for main, 1 for side1, ...
int branch_id(const std::string& name) {
  return name == "main" ? 0 : std::stoi(name.substr(4));
}

} // namespace

std::size_t inlet_of(const std::vector<End>& ends, const std::optional<Vec3>& inlet) {
  if (ends.size() < 2)
    throw InputError("a lumen needs an inlet and an outlet", "ends of the surface",
                     std::to_string(ends.size()) + " flat or open ends found",
                     "cut each end of the vessel flat, or leave it open");
  if (inlet)
    return end_near(ends, *inlet, "--inlet");
  const auto largest =
      std::max_element(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.area < b.area; });
  return static_cast<std::size_t>(largest - ends.begin());
}

Naming naming_from_points(const std::vector<End>& ends, const std::optional<Vec3>& inlet,
                          const std::vector<Vec3>& outlets) {
  Naming naming{inlet_of(ends, inlet), {}};
  if (outlets.empty())
    return naming;
  naming.branch.assign(ends.size(), -1);
  for (std::size_t k = 0; k < outlets.size(); ++k) {
    const std::size_t e = end_near(ends, outlets[k], "--outlet");
    if (e == naming.inlet || naming.branch[e] >= 0)
      throw InputError("two points name the same end", "--outlet", point_text(outlets[k]),
                       "give one point near each outlet");
    naming.branch[e] = static_cast<int>(k);
  }
  if (outlets.size() + 1 != ends.size())
    throw InputError("not every outlet has a point", "--outlet",
                     std::to_string(outlets.size()) + " points, " + std::to_string(ends.size() - 1) + " outlets",
                     "give one point near each outlet, or none");
  return naming;
}

Naming naming_from_earlier(std::vector<End>& ends, const nlohmann::json& like) {
  const auto& earlier = like.at("ends");
  if (earlier.size() != ends.size())
    throw InputError("the ends do not match the earlier state's", "ends",
                     std::to_string(ends.size()) + " found, " + std::to_string(earlier.size()) + " expected",
                     "give the surface and the anatomy.json of the same vessel");
  Naming naming;
  std::vector<bool> taken(ends.size(), false);
  for (std::size_t e = 0; e < ends.size(); ++e) {
    std::size_t best = 0;
    double nearest = 1e300;
    for (std::size_t k = 0; k < earlier.size(); ++k) {
      const auto& c = earlier[k].at("centre_mm");
      const double d = (ends[e].centre - Vec3(c[0], c[1], c[2])).norm();
      if (d < nearest) {
        nearest = d;
        best = k;
      }
    }
    if (taken[best])
      throw InputError("two ends match the same end of the earlier state", point_text(ends[e].centre),
                       earlier[best].at("name").get<std::string>(),
                       "give the surface and the anatomy.json of the same vessel");
    taken[best] = true;
    ends[e].extension = earlier[best].value("extension_mm", 0.0);
    const bool inlet = earlier[best].at("kind") == "inlet";
    if (inlet)
      naming.inlet = e;
    naming.branch.push_back(inlet ? -1 : branch_id(earlier[best].at("branch").get<std::string>()));
  }
  return naming;
}

} // namespace anatomy
