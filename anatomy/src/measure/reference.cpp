#include "measure/reference.hpp"
#include <algorithm>
#include <optional>

namespace anatomy {
namespace {

constexpr double flow_exponent = 2.55;
constexpr double upper = 0.75;          // quantile of the diameters where the first fit lies: narrowings do not move it
constexpr double middle = 0.5;          // the same beside a dilatation, which would move the upper quantile
constexpr double band = 0.03;           // of the diameter: sections this near to the profile count as healthy
constexpr std::size_t fewest = 8;       // sections for a profile
constexpr double least_widening = 1.15; // of a dilatation: an ostium's sections may be 8 % too wide
constexpr double many_more = 1.25;      // ratio of healthy sections, by the median fit over those by the envelope
constexpr double ectatic = 1.5;         // width over the widest lumen beside it (definition of coronary ectasia)
constexpr double least_share = 0.1;     // of D^m without side branches: least value behind them

// Sum of d_k^m over the side branches that leave before s, in mm^m.
double carried_off(const std::vector<std::pair<double, double>>& sides, double s) {
  double sum = 0;
  for (const auto& [at, diameter] : sides)
    if (at < s)
      sum += std::pow(diameter, flow_exponent);
  return sum;
}

void fit(ReferenceProfile& profile, const std::vector<Calibre>& trunk, const std::vector<double>& weight) {
  double w = 0, ws = 0, wd = 0, wss = 0, wsd = 0;
  for (std::size_t i = 0; i < trunk.size(); ++i) {
    w += weight[i];
    ws += weight[i] * trunk[i].s;
    wd += weight[i] * trunk[i].diameter;
    wss += weight[i] * trunk[i].s * trunk[i].s;
    wsd += weight[i] * trunk[i].s * trunk[i].diameter;
  }
  const double spread = wss - ws * ws / w;
  profile.slope = spread > 1e-9 * wss ? (wsd - ws * wd / w) / spread : 0;
  profile.at_start = (wd - profile.slope * ws) / w;
  if (profile.slope > 0) // a healthy vessel does not widen
    profile = {wd / w, 0, std::move(profile.sides)};
}

// Quantile regression by iteratively reweighted least squares, then least squares of the sections near that line.
ReferenceProfile fitted(const std::vector<Calibre>& measured, std::vector<std::pair<double, double>> sides,
                        double quantile = upper) {
  std::vector<Calibre> trunk = measured;
  for (Calibre& c : trunk)
    c.diameter = std::pow(std::pow(c.diameter, flow_exponent) + carried_off(sides, c.s), 1 / flow_exponent);
  std::vector<double> weight(trunk.size(), 1);
  ReferenceProfile profile;
  profile.sides = std::move(sides);
  fit(profile, trunk, weight);
  const auto residual = [&](const Calibre& c) { return c.diameter - (profile.at_start + profile.slope * c.s); };
  for (int k = 0; k < 100; ++k) {
    for (std::size_t i = 0; i < trunk.size(); ++i) {
      const double r = residual(trunk[i]);
      weight[i] = (r > 0 ? quantile : 1 - quantile) / std::max(std::abs(r), 1e-4);
    }
    fit(profile, trunk, weight);
  }
  for (int k = 0; k < 5; ++k) {
    for (std::size_t i = 0; i < trunk.size(); ++i)
      weight[i] = std::abs(residual(trunk[i])) < band * trunk[i].diameter ? 1 : 1e-6;
    fit(profile, trunk, weight);
  }
  return profile;
}

std::size_t healthy(const ReferenceProfile& profile, const std::vector<Calibre>& measured) {
  return static_cast<std::size_t>(std::count_if(measured.begin(), measured.end(), [&](const Calibre& c) {
    return std::abs(c.diameter - profile.diameter(c.s)) < band * c.diameter;
  }));
}

// The stretch of the sections wider than the profile, if there are at least `fewest` healthy ones before and after it.
std::optional<std::pair<double, double>> dilatation(const ReferenceProfile& profile,
                                                    const std::vector<Calibre>& measured) {
  const auto wide = [&](const Calibre& c) { return c.diameter > profile.diameter(c.s) / (1 - band); };
  const auto first = std::find_if(measured.begin(), measured.end(), wide);
  const auto last = std::find_if(measured.rbegin(), measured.rend(), wide).base();
  if (first == measured.end() || healthy(profile, {measured.begin(), first}) < fewest ||
      healthy(profile, {last, measured.end()}) < fewest)
    return std::nullopt;
  return std::pair{first->s, (last - 1)->s};
}

// The sections without an ectasia. An ectasia is one stretch with at least `fewest` sections before and behind it, and
// `ectatic` times as wide as any of them. Its flanks are left out as well.
std::vector<Calibre> without_ectasia(std::vector<Calibre> measured, const Branch& branch, std::vector<Repair>& notes) {
  const std::size_t all = measured.size();
  const auto wider = [](const Calibre& a, const Calibre& b) { return a.diameter < b.diameter; };
  Calibre widest{};
  while (measured.size() > 2 * fewest) {
    const Calibre peak = *std::max_element(measured.begin(), measured.end(), wider);
    const auto wide = [&](const Calibre& c) { return c.diameter >= peak.diameter / ectatic; };
    const auto first = std::find_if(measured.begin(), measured.end(), wide);
    const auto last = std::find_if(measured.rbegin(), measured.rend(), wide).base();
    if (first - measured.begin() < static_cast<long>(fewest) || measured.end() - last < static_cast<long>(fewest) ||
        !std::all_of(first, last, wide))
      break;
    if (measured.size() == all)
      widest = peak;
    measured.erase(first, last);
  }
  if (measured.size() < all) {
    char detail[192];
    std::snprintf(detail, sizeof detail, "%s about %.1f mm along it: up to %.2f mm wide", branch.name.c_str(), widest.s,
                  widest.diameter);
    notes.push_back({"ectasia left out of the reference", 1, detail, true});
  }
  return measured;
}

// The fit to the upper envelope, unless that follows a dilatation, a stretch wider than the vessel on both sides of it.
ReferenceProfile beside_dilatations(const std::vector<Calibre>& measured, const Branch& branch,
                                    std::vector<Repair>& notes) {
  const ReferenceProfile envelope = fitted(measured, {}), low = fitted(measured, {}, middle);
  const auto wide = dilatation(low, measured);
  if (!wide)
    return envelope;
  double widest = 0, widening = 0;
  for (const Calibre& c : measured)
    if (c.s >= wide->first && c.s <= wide->second) {
      widest = std::max(widest, c.diameter);
      widening = std::max(widening, c.diameter / low.diameter(c.s));
    }
  if (widening < least_widening ||
      static_cast<double>(healthy(low, measured)) < many_more * static_cast<double>(healthy(envelope, measured)))
    return envelope;
  char detail[192];
  std::snprintf(detail, sizeof detail, "%s from %.1f to %.1f mm along it: up to %.2f mm wide, %.2f mm beside it",
                branch.name.c_str(), wide->first, wide->second, widest, low.diameter(wide->first));
  notes.push_back({"dilatation left out of the reference", 1, detail, true});
  return low;
}

ReferenceProfile constant(const Branch& branch) {
  std::vector<double> radius = branch.radius;
  std::nth_element(radius.begin(), radius.begin() + static_cast<long>(radius.size() / 2), radius.end());
  return {2 * radius[radius.size() / 2], 0, {}};
}

} // namespace

double ReferenceProfile::diameter(double s) const {
  const double line = at_start + slope * s, trunk = std::pow(line, flow_exponent);
  if (sides.empty())
    return line;
  return std::pow(std::max(trunk - carried_off(sides, s), least_share * trunk), 1 / flow_exponent);
}

std::vector<Calibre> calibres(const std::vector<Branch>& branches, const std::vector<Section>& sections,
                              std::size_t branch) {
  std::vector<Calibre> out;
  for (const Section& section : sections)
    if (section.branch == branch && section.flag != "end")
      out.push_back({branches[branch].s[section.sample], section.equivalent_diameter(), section.flag == "ostium"});
  return out;
}

std::vector<ReferenceProfile> reference_profiles(const std::vector<Branch>& branches,
                                                 const std::vector<Section>& sections, std::vector<Repair>& notes) {
  std::vector<ReferenceProfile> profiles(branches.size());
  // a branch comes after its side branches, whose calibre it needs: the deepest generation first
  std::vector<std::size_t> order(branches.size());
  const auto generation = [&](std::size_t b) {
    int n = 0;
    for (int parent = branches[b].parent; parent >= 0; parent = branches[static_cast<std::size_t>(parent)].parent)
      ++n;
    return n;
  };
  for (std::size_t b = 0; b < order.size(); ++b)
    order[b] = b;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return generation(a) > generation(b); });
  for (std::size_t b : order) {
    const std::vector<Calibre> measured = without_ectasia(calibres(branches, sections, b), branches[b], notes);
    if (measured.size() < fewest) {
      profiles[b] = constant(branches[b]);
      notes.push_back({"constant reference diameter", 1, branches[b].name + " is too short for a profile"});
      continue;
    }
    std::vector<std::pair<double, double>> sides;
    for (std::size_t k = 0; k < branches.size(); ++k)
      if (branches[k].parent == static_cast<int>(b))
        sides.emplace_back(branches[k].s_on_parent, profiles[k].diameter(branches[k].s_outside));
    profiles[b] = beside_dilatations(measured, branches[b], notes);
    if (sides.empty())
      continue;
    const ReferenceProfile stepped = fitted(measured, sides);
    if (healthy(stepped, measured) > healthy(profiles[b], measured))
      profiles[b] = stepped;
  }
  return profiles;
}

} // namespace anatomy
