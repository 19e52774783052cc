#include "app/inlet_doubts.hpp"
#include <algorithm>

namespace anatomy {
namespace {

constexpr double about_as_wide = 0.9; // over the inlet's diameter
constexpr double widening = 1.1;      // of the last third's widest ball over that of the first
constexpr double leans_back = -0.2;   // cosine: twelve degrees beyond a right angle
constexpr double leaving = 2;         // radii of the side branch along which its direction is taken

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

std::string by_widening(const Branch& main) {
  const auto third = static_cast<std::ptrdiff_t>(main.radius.size() / 3);
  const double first = *std::max_element(main.radius.begin(), main.radius.begin() + std::max<std::ptrdiff_t>(third, 1));
  const double last = *std::max_element(main.radius.end() - std::max<std::ptrdiff_t>(third, 1), main.radius.end());
  if (last < widening * first)
    return "";
  char text[120];
  std::snprintf(text, sizeof text, "the vessel widens from it, from %.2f to %.2f mm", 2 * first, 2 * last);
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
  int all = 0, back = 0;
  for (const Branch& side : branches) {
    if (side.parent < 0)
      continue;
    const double length = leaving * side.radius_at(side.s_outside);
    const Branch& parent = branches[static_cast<std::size_t>(side.parent)];
    ++all;
    back += direction(side, side.s_outside, length).dot(direction(parent, side.s_on_parent, length)) < leans_back;
  }
  if (2 * back <= all)
    return "";
  return std::to_string(back) + " of " + std::to_string(all) + " side branches lean back towards it";
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
