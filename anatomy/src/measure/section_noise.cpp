#include "measure/section_noise.hpp"
#include <Eigen/SparseCholesky>
#include <algorithm>

namespace anatomy {
namespace {

constexpr double stride_mm = 0.5;    // mm; sections nearer to each other share vertices of the wall, and so their noise
constexpr double usual_radius = 1.5; // mm, radius for which the noise is stated
constexpr std::size_t fewest_for_noise = 5; // fewer sections give no estimate of the noise
constexpr Eigen::Index shortest_run = 8;    // the areas of a branch with fewer sections are not smoothed
// Mallows' C_p charges a price for each degree of freedom. This factor guards against fits to chance (Kim & Gu 2004).
constexpr double price_factor = 1.4;
// Degrees of freedom of a profile that bends twice. With few sections its price rises as in the corrected AIC (Hurvich
// & Tsai 1989).
constexpr double double_bend_freedom = 5;
constexpr int penalty_bands = 3; // bands of the penalty matrix on either side of its diagonal

using Sparse = Eigen::SparseMatrix<double>;

// Sections along one branch, with their equivalent radii (mm) and weights, one for each sample of the axis. The weight
// is 0 if a section is missing, or closed across the mouth of another branch.
struct RadiusProfile {
  std::vector<Section*> section;
  Eigen::VectorXd radius, weight;
};

RadiusProfile radii_along(std::vector<Section>& sections, std::size_t branch) {
  RadiusProfile profile;
  std::size_t first = 0;
  for (Section& section : sections) {
    if (section.branch != branch || section.flag == SectionFlag::end)
      continue;
    if (profile.section.empty())
      first = section.sample;
    profile.section.resize(section.sample - first + 1, nullptr);
    profile.section.back() = &section;
  }
  const auto n = static_cast<Eigen::Index>(profile.section.size());
  profile.radius = profile.weight = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i)
    if (const Section* section = profile.section[static_cast<std::size_t>(i)];
        section && section->flag == SectionFlag::ok) {
      profile.radius(i) = section->equivalent_diameter() / 2;
      // the variance of a mean radius falls as 1 / n with the n vertices round it, so as 1 / radius
      profile.weight(i) = profile.radius(i) / usual_radius;
    }
  return profile;
}

Eigen::Index stride_of(const Branch& branch) {
  return std::max<Eigen::Index>(1, std::lround(stride_mm / (branch.s[1] - branch.s[0])));
}

Sparse third_differences(Eigen::Index n) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i + 3 < n; ++i)
    for (const auto& [k, c] : {std::pair{0, -1.0}, {1, 3.0}, {2, -3.0}, {3, 1.0}})
      entries.emplace_back(static_cast<int>(i), static_cast<int>(i) + k, c);
  Sparse d(n - 3, n);
  d.setFromTriplets(entries.begin(), entries.end());
  return d;
}

// Diagonal of the inverse of L D L^T, where L has the bandwidth `penalty_bands`. Computed from the last row upwards
// (Erisman & Tinney 1975).
Eigen::VectorXd inverse_diagonal(const Sparse& l, const Eigen::VectorXd& d) {
  const Eigen::Index n = d.size();
  Eigen::MatrixXd z = Eigen::MatrixXd::Zero(n + penalty_bands, penalty_bands + 1),
                  low = z; // z(i, k): element (i, i + k) of the inverse
  for (int j = 0; j < l.outerSize(); ++j)
    for (Sparse::InnerIterator it(l, j); it; ++it)
      if (it.row() > j)
        low(j, it.row() - j) = it.value();
  for (Eigen::Index i = n; i-- > 0;) {
    for (Eigen::Index k = penalty_bands; k > 0; --k)
      for (Eigen::Index j = 1; j <= penalty_bands; ++j)
        z(i, k) -= low(i, j) * z(i + std::min(j, k), std::abs(j - k));
    z(i, 0) = 1 / d(i);
    for (Eigen::Index j = 1; j <= penalty_bands; ++j)
      z(i, 0) -= low(i, j) * z(i, j);
  }
  return z.col(0).head(n);
}

// The line fitted by weighted least squares to the points (i, y_i), evaluated at every i.
Eigen::VectorXd line_through(const Eigen::VectorXd& y, const Eigen::VectorXd& w) {
  const Eigen::ArrayXd x = Eigen::ArrayXd::LinSpaced(y.size(), 0, static_cast<double>(y.size() - 1));
  const double mean_x = w.dot(x.matrix()) / w.sum(), mean_y = w.dot(y) / w.sum();
  const Eigen::ArrayXd from_mean = x - mean_x;
  const double slope = (w.array() * from_mean * (y.array() - mean_y)).sum() / (w.array() * from_mean.square()).sum();
  return (mean_y + slope * from_mean).matrix();
}

// The smooth profile (mm, one radius for each sample): a smoothing spline. Its penalty factor is the one with the least
// Mallows' C_p. Samples nearer than `stride` share vertices of the wall, so their common noise would pass for shape.
// Therefore only every stride-th sample enters C_p. The spline with the chosen factor is then fitted to all samples.
// The penalty is on third differences, so the stiffest spline is still a parabola. A straight line competes as well.
// @param stride distance between the samples that enter C_p, in samples
// @param sigma standard deviation (mm) that the noise gives to a radius of 1.5 mm
Eigen::VectorXd smoothed(const RadiusProfile& profile, Eigen::Index stride, double sigma) {
  const Eigen::VectorXd& y = profile.radius;
  Eigen::VectorXd w = profile.weight;
  for (Eigen::Index i = 0; i < w.size(); ++i)
    w(i) = i % stride == 0 ? static_cast<double>(stride) * w(i) : 0;
  const auto sections = static_cast<double>((w.array() > 0).count());
  const double price = std::max(price_factor, sections / std::max(sections - double_bend_freedom - 1, 1.0));
  const Sparse d = third_differences(y.size()), penalty = d.transpose() * d;
  const auto system = [&](const Eigen::VectorXd& weight, double lambda) {
    Sparse diagonal(y.size(), y.size());
    diagonal.setIdentity();
    diagonal.diagonal() = weight;
    return Sparse(diagonal + lambda * penalty);
  };
  const auto score_of = [&](const Eigen::VectorXd& z, double freedom) {
    return w.dot((z - y).cwiseAbs2()) / static_cast<double>(stride) + 2 * price * sigma * sigma * freedom;
  };
  Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> solver;
  double best = 0, least = 1e300;
  for (double log_lambda = -3; log_lambda <= 9; log_lambda += 0.25) {
    solver.compute(system(w, std::pow(10.0, log_lambda)));
    if (solver.info() != Eigen::Success)
      continue;
    const Eigen::VectorXd z = solver.solve(Eigen::VectorXd(w.cwiseProduct(y)));
    const Sparse l = solver.matrixL();
    const double score = score_of(z, inverse_diagonal(l, solver.vectorD()).dot(w));
    if (score < least) {
      least = score;
      best = std::pow(10.0, log_lambda);
    }
  }
  if (score_of(line_through(y, w), 2) < least)
    return line_through(y, profile.weight);
  solver.compute(system(profile.weight, best));
  return solver.solve(Eigen::VectorXd(profile.weight.cwiseProduct(y)));
}

} // namespace

double area_noise(const std::vector<Section>& sections) {
  std::vector<double> found;
  for (const Section& section : sections)
    if (section.flag == SectionFlag::ok && section.scatter >= 0)
      found.push_back(section.scatter * std::sqrt(section.equivalent_diameter() / 2 / usual_radius));
  if (found.size() < fewest_for_noise)
    return 0;
  const auto middle = found.begin() + static_cast<long>(found.size() / 2);
  std::nth_element(found.begin(), middle, found.end());
  return 2 * *middle / usual_radius;
}

void smooth_noisy_areas(const std::vector<Branch>& branches, std::vector<Section>& sections,
                        std::vector<Repair>& notes) {
  const double noise = area_noise(sections);
  if (noise < least_area_noise)
    return;
  std::size_t changed = 0;
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const RadiusProfile profile = radii_along(sections, b);
    if ((profile.weight.array() > 0).count() < shortest_run)
      continue;
    const Eigen::VectorXd smooth = smoothed(profile, stride_of(branches[b]), noise * usual_radius / 2);
    for (Eigen::Index i = 0; i < smooth.size(); ++i) {
      if (profile.weight(i) == 0)
        continue;
      Section& section = *profile.section[static_cast<std::size_t>(i)];
      const double ratio = smooth(i) / profile.radius(i);
      section.area *= ratio * ratio;
      section.min_diameter *= ratio;
      section.max_diameter *= ratio;
      ++changed;
    }
  }
  char detail[120];
  std::snprintf(detail, sizeof detail, "the wall's noise scatters them by %.1f %% of an area at radius 1.5 mm",
                100 * noise);
  notes.push_back({"areas smoothed along the axis", changed, detail});
}

} // namespace anatomy
