#include "app/inlet_doubts.hpp"
#include <algorithm>

namespace anatomy {
namespace {

constexpr double about_as_wide = 0.9; // over the inlet's diameter
constexpr double widening = 1.04;     // of the last third's healthy width over that of the first
constexpr double healthy = 0.9;       // quantile of the widths in a third: lesions and short ectasias do not count
constexpr double leans_back = -0.45;  // mean cosine: 27 degrees beyond a right angle, where a conus branch has 25
constexpr double leaving = 4;         // radii of the side branch along which its direction is taken

std::string by_another_end(const std::vector<End>& ends) {
  const End *inlet = nullptr, *other = nullptr;
  for (const End& end : ends)
    if (end.inlet)
      inlet = &end;
    else if (!other || end.area > other->area)
      other = &end;
  if (!inlet || !other || other->radius() < about_as_wide * inlet->radius())
    return "";
  char text[160];
  std::snprintf(text, sizeof text, "it is %.2f mm wide, the end at %s %.2f mm", 2 * inlet->radius(),
                place(other->centre).c_str(), 2 * other->radius());
  return text;
}

double healthy_width(std::vector<double> radii) {
  const auto at = static_cast<std::ptrdiff_t>(healthy * static_cast<double>(radii.size() - 1));
  std::nth_element(radii.begin(), radii.begin() + at, radii.end());
  return 2 * radii[static_cast<std::size_t>(at)];
}

std::string by_widening(const Branch& main) {
  const auto third = std::max<std::ptrdiff_t>(std::ssize(main.radius) / 3, 1);
  const double first = healthy_width({main.radius.begin(), main.radius.begin() + third});
  const double last = healthy_width({main.radius.end() - third, main.radius.end()});
  if (last < widening * first)
    return "";
  char text[120];
  std::snprintf(text, sizeof text, "the vessel widens from it, from %.2f to %.2f mm", first, last);
  return text;
}

// The direction of a branch from s on, along `length` mm.
Vec3 direction(const Branch& branch, double s, double length) {
  const auto at = [&](double where) {
    const auto i = std::lower_bound(branch.s.begin(), branch.s.end(), where) - branch.s.begin();
    return branch.x[static_cast<std::size_t>(std::min<std::ptrdiff_t>(i, std::ssize(branch.x) - 1))];
  };
  return (at(s + length) - at(s)).normalized();
}

std::string by_side_branches(const std::vector<Branch>& branches) {
  int all = 0;
  double sum = 0;
  for (const Branch& side : branches) {
    if (side.parent < 0)
      continue;
    const double length = leaving * side.radius_at(side.s_outside);
    const Branch& parent = branches[static_cast<std::size_t>(side.parent)];
    ++all;
    sum += direction(side, side.s_outside, length).dot(direction(parent, side.s_on_parent, length));
  }
  return sum < leans_back * all ? "the side branches lean back towards it" : "";
}

} // namespace

void doubt_inlet(const std::vector<End>& ends, const std::vector<Branch>& branches, std::vector<Repair>& notes) {
  std::string why;
  for (const std::string& one : {by_another_end(ends), by_widening(branches.front()), by_side_branches(branches)})
    if (!one.empty())
      why += (why.empty() ? "" : "; ") + one;
  if (!why.empty())
    notes.push_back(
        {"inlet chosen by its width alone", 1, why + ". If the inlet is elsewhere, name it by --inlet", true});
}

} // namespace anatomy
