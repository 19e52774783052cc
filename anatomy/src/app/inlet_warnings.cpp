#include "app/inlet_warnings.hpp"
#include <algorithm>

// The functions ..._doubt() return a reason to doubt the inlet as text, or an empty text.

namespace anatomy {
namespace {

constexpr double equal_width_ratio = 0.9; // a width of this share of the inlet's diameter is about as wide as the inlet
// Main widens if the healthy width of its last third is at least this many times that of its first third.
constexpr double widening_ratio = 1.04;
// Main's end is narrowed if it is at most this share of the healthy width of main's last third.
constexpr double narrowed_ratio = 0.85;
// The healthy width of a third is this quantile of its widths. So lesions and short ectasias do not count.
constexpr double healthy_quantile = 0.9;
// Side branches lean back if the mean cosine of their angle with the parent is below this, 27 degrees beyond a right
// angle. A conus branch leans back by 25 degrees.
constexpr double leaning_back_cosine = -0.45;
// An outlet this many times as wide as the named inlet gives a warning.
constexpr double wider_outlet_ratio = 1.25;
// A branch that turns by this many degrees gives a warning. A left main turns into the circumflex by at most a right
// angle.
constexpr double turning_back_degrees = 100;
constexpr double direction_radii = 4; // directions are taken over this many radii of a branch

// The healthy width (mm) of a part of a vessel with these inscribed radii (mm).
double healthy_width(std::vector<double> radii) {
  const auto at = static_cast<std::ptrdiff_t>(healthy_quantile * static_cast<double>(radii.size() - 1));
  std::nth_element(radii.begin(), radii.begin() + at, radii.end());
  return 2 * radii[static_cast<std::size_t>(at)];
}

// The healthy widths (mm) of the first and the last third of the main branch.
std::pair<double, double> healthy_widths(const Branch& main) {
  const auto third = std::max<std::ptrdiff_t>(std::ssize(main.radius) / 3, 1);
  return {healthy_width({main.radius.begin(), main.radius.begin() + third}),
          healthy_width({main.radius.end() - third, main.radius.end()})};
}

std::string widening_doubt(const Branch& main) {
  const auto [first, last] = healthy_widths(main);
  if (last < widening_ratio * first)
    return "";
  char text[120];
  std::snprintf(text, sizeof text, "the vessel widens from it, from %.2f to %.2f mm", first, last);
  return text;
}

std::string narrowed_end_doubt(const std::vector<End>& ends, const Branch& main) {
  const double last = healthy_widths(main).second;
  const End& end = ends[main.end];
  const auto inlet = std::find_if(ends.begin(), ends.end(), [](const End& one) { return one.inlet; });
  if (inlet == ends.end() || 2 * end.radius() > narrowed_ratio * last || last < equal_width_ratio * 2 * inlet->radius())
    return "";
  char text[200];
  std::snprintf(text, sizeof text, "it is %.2f mm wide, the vessel %.2f mm before it narrows to %.2f mm at its end %s",
                2 * inlet->radius(), last, 2 * end.radius(), point_text(end.centre).c_str());
  return text;
}

// The unit direction from the place s (mm) of a branch to the place `length` mm further along it.
Vec3 direction(const Branch& branch, double s, double length) {
  const auto at = [&](double where) {
    const auto i = std::lower_bound(branch.s.begin(), branch.s.end(), where) - branch.s.begin();
    return branch.x[static_cast<std::size_t>(std::min<std::ptrdiff_t>(i, std::ssize(branch.x) - 1))];
  };
  return (at(s + length) - at(s)).normalized();
}

std::string side_branch_doubt(const std::vector<Branch>& branches) {
  int all = 0;
  double sum = 0;
  for (const Branch& side : branches) {
    if (side.parent < 0)
      continue;
    const double length = direction_radii * side.radius_at(side.s_outside);
    const Branch& parent = branches[static_cast<std::size_t>(side.parent)];
    ++all;
    sum += direction(side, side.s_outside, length).dot(direction(parent, side.s_on_parent, length));
  }
  return sum < leaning_back_cosine * all ? "the side branches lean back towards it" : "";
}

// The greatest turn (degrees) of an axis within `length` mm of s, and its place (mm). A turn is the angle between the
// directions over `length` mm before and behind a place.
std::pair<double, double> greatest_turn(const Branch& branch, double s, double length) {
  std::pair<double, double> greatest{0, s};
  for (double at : branch.s)
    if (std::abs(at - s) < length && at > length && at < branch.s.back() - length) {
      const double cosine = direction(branch, at - length, length).dot(direction(branch, at, length));
      greatest = std::max(greatest, {std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / pi, at});
    }
  return greatest;
}

} // namespace

std::string wide_end_doubt(const std::vector<End>& ends) {
  const End *inlet = nullptr, *other = nullptr;
  for (const End& end : ends)
    if (end.inlet)
      inlet = &end;
    else if (!other || end.area > other->area)
      other = &end;
  if (!inlet || !other || other->radius() < equal_width_ratio * inlet->radius())
    return "";
  char text[160];
  std::snprintf(text, sizeof text, "it is %.2f mm wide, the end at %s %.2f mm", 2 * inlet->radius(),
                point_text(other->centre).c_str(), 2 * other->radius());
  return text;
}

void warn_of_narrow_inlet(const std::vector<End>& ends, std::vector<Repair>& notes) {
  const auto inlet = std::find_if(ends.begin(), ends.end(), [](const End& end) { return end.inlet; });
  const auto widest =
      std::max_element(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.area < b.area; });
  if (inlet == ends.end() || widest->radius() < wider_outlet_ratio * inlet->radius())
    return;
  char detail[240];
  std::snprintf(detail, sizeof detail,
                "the inlet that was named is %.2f mm wide, the outlet at %s %.2f mm. Does blood enter there?",
                2 * inlet->radius(), point_text(widest->centre).c_str(), 2 * widest->radius());
  notes.push_back({"inlet narrower than an outlet", 1, detail, true});
}

void warn_of_turning_back(const std::vector<Branch>& branches, std::vector<Repair>& notes) {
  for (const Branch& side : branches) {
    if (side.parent < 0)
      continue;
    const Branch& parent = branches[static_cast<std::size_t>(side.parent)];
    const auto [turn, at] =
        greatest_turn(parent, side.s_on_parent, direction_radii * parent.radius_at(side.s_on_parent));
    if (turn < turning_back_degrees)
      continue;
    char detail[320];
    std::snprintf(
        detail, sizeof detail,
        "%s turns back by %.0f degrees %.1f mm along it, where %s leaves, as from an artery into a graft. Its "
        "sections there may be false; name the ends by --inlet and --outlet, the main vessel's outlet first",
        parent.name.c_str(), turn, at, side.name.c_str());
    notes.push_back({"a vessel turns back at a branch", 1, detail, true});
  }
}

void warn_of_doubtful_inlet(const std::vector<End>& ends, const std::vector<Branch>& branches,
                            std::vector<Repair>& notes) {
  std::string doubts;
  for (const std::string& doubt : {wide_end_doubt(ends), narrowed_end_doubt(ends, branches.front()),
                                   widening_doubt(branches.front()), side_branch_doubt(branches)})
    if (!doubt.empty())
      doubts += (doubts.empty() ? "" : "; ") + doubt;
  if (!doubts.empty())
    notes.push_back(
        {"inlet chosen by its width alone", 1, doubts + ". If the inlet is elsewhere, name it by --inlet", true});
}

} // namespace anatomy
