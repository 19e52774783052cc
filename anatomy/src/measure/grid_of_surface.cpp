#include "measure/grid_of_surface.hpp"
#include <algorithm>
#include <complex>

namespace anatomy {
namespace {

using Complex = std::complex<double>;
constexpr double finest_spacing = 0.15, coarsest_spacing = 1.2; // mm, spacings of images that show coronary lumens
constexpr double bin_width = 0.02; // mm, width of a bin; it weakens the wave of the finest spacing by 3 %
constexpr double wave_band = 0.25; // waves are neighbours if their frequencies differ by less than this share
// Least ratio of a wave's strength to its neighbours' median. Contoured surfaces have 4.4 to 24, others up to 2.8.
constexpr double least_wave_ratio = 4;
constexpr double least_wave_share = 0.02; // least strength of a wave, as Spectrum defines it
constexpr double least_extent = 8; // mm; a shorter axis is skipped, since the vessel's own width makes waves along it
constexpr std::size_t fewest_vertices = 1000; // fewer vertices have strong waves by chance

// Number of vertices in each bin along one coordinate axis.
std::vector<double> vertex_histogram(const Mesh& mesh, int axis) {
  double low = 1e300, high = -1e300;
  for (Vertex v : mesh.vertices()) {
    low = std::min(low, vec(mesh.point(v))[axis]);
    high = std::max(high, vec(mesh.point(v))[axis]);
  }
  std::vector<double> count(static_cast<std::size_t>((high - low) / bin_width) + 1, 0);
  for (Vertex v : mesh.vertices())
    ++count[static_cast<std::size_t>((vec(mesh.point(v))[axis] - low) / bin_width)];
  return count;
}

// Strengths of waves in the density of the vertices, from the coarsest spacing to the finest. The strength at frequency
// f is |sum of exp(2 pi i f x) over the vertices| / their number. It is 1 if all vertices are whole wavelengths apart.
// Successive frequencies differ by a fifth of 1 / (extent of the surface).
struct Spectrum {
  double first = 1 / coarsest_spacing, step;
  std::vector<double> share;

  Spectrum(const std::vector<double>& count, std::size_t vertices)
      : step(0.2 / (bin_width * static_cast<double>(count.size()))) {
    for (double f = first; f < 1 / finest_spacing; f += step) {
      const Complex turn = std::polar(1.0, 2 * pi * f * bin_width);
      Complex sum = 0, at = 1;
      for (double n : count) {
        sum += n * at;
        at *= turn;
      }
      share.push_back(std::abs(sum) / static_cast<double>(vertices));
    }
  }
};

// Wavelength (mm) of the strongest wave; 0 if it is weak or does not stand out among its neighbours.
double strongest_wavelength(const Spectrum& spectrum) {
  const auto top = std::max_element(spectrum.share.begin(), spectrum.share.end());
  const auto at = static_cast<double>(top - spectrum.share.begin());
  const double frequency = spectrum.first + at * spectrum.step;
  const auto reach = static_cast<std::ptrdiff_t>(wave_band * frequency / spectrum.step);
  std::vector<double> near(top - std::min(reach, top - spectrum.share.begin()),
                           top + std::min(reach, spectrum.share.end() - top));
  const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
  std::nth_element(near.begin(), middle, near.end());
  return *top > least_wave_share && *top > least_wave_ratio * *middle ? 1 / frequency : 0;
}

} // namespace

double grid_of_surface(const Mesh& mesh) {
  if (mesh.number_of_vertices() < fewest_vertices)
    return 0;
  double largest = 0;
  int axes = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> count = vertex_histogram(mesh, axis);
    if (bin_width * static_cast<double>(count.size()) < least_extent)
      continue;
    const double spacing = strongest_wavelength(Spectrum(count, mesh.number_of_vertices()));
    if (spacing == 0)
      return 0;
    largest = std::max(largest, spacing);
    ++axes;
  }
  return axes > 1 ? largest : 0; // along a single axis the wave may come from rings of vertices round the vessel
}

} // namespace anatomy
